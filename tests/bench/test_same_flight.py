"""A flight counts once, whatever number of files holds it; two recorders of one flight share its
wind.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench import BadInputError, FlightLog, calibrate, read_log, reconcile, write_log
from pitotbench.bench import workflow
from pitotbench.bench.folder_logs import calibrate_folder
from pitotbench.browser.work import Request, answer
from pitotbench.cli.app import main
from pitotbench.logbook.same_flight import distinct, recorders
from pitotbench.records.calibration_request import NamedFile

# Several voices of one answer are looked at: each log is fitted once.
pytestmark = pytest.mark.usefixtures("one_fit_of_each_log")

START = "2024-05-01 10:00:00"


def flown(seed: int, start: str = "", airplane: str = "") -> FlightLog:
    log = fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air(), seed=seed)
    named = {"start": start, "airplane": airplane}
    return replace(log, header={**log.header, **{k: v for k, v in named.items() if v}})


@pytest.fixture(scope="module")
def log() -> FlightLog:
    return flown(1)


def corrections(document):
    return [(point["correction_kt"], point["two_sigma_kt"]) for point in document["curve"]]


def test_a_copy_in_another_container_adds_nothing_to_the_answer(log, tmp_path, capsys):
    paths = [write_log(log, tmp_path / name) for name in ("one.csv", "copy.parquet")]
    assert main(["calibrate", str(paths[0]), "--json"]) == 0
    once = json.loads(capsys.readouterr().out)
    assert main(["calibrate", *map(str, paths), "--json"]) == 0
    twice = json.loads(capsys.readouterr().out)
    assert corrections(twice) == corrections(once)
    words = "the same rows are in one.csv and copy.parquet: the flight counts once"
    assert words in twice["warnings"]
    assert main(["calibrate", *map(str, paths)]) == 0
    assert words[1:] in capsys.readouterr().out  # it is said without -v


@pytest.mark.parametrize("separately", [False, True])
def test_a_folder_and_a_list_count_a_copy_once(log, tmp_path, separately):
    paths = [write_log(log, tmp_path / name) for name in ("a.csv", "b.csv")]
    one, other = calibrate_folder(paths, read_log, separately)
    assert [len(one.flights), len(other.flights)] == [1, 0]
    found, (single,) = one.flights[0].calibration, calibrate_folder(paths[:1], read_log)
    expected = single.flights[0].calibration
    assert np.array_equal(found.curve.correction, expected.curve.correction)
    assert np.array_equal(found.curve.two_sigma, expected.curve.two_sigma)
    assert "the same rows are in a.csv and b.csv: the flight counts once" in found.warnings


def test_python_answers_each_log_of_a_list_with_tables_among_them(log):
    table = log.to_frame()
    once, each, copy = calibrate(table), *calibrate([table, table.copy()])
    for found in (each, copy):
        assert np.array_equal(found.curve.correction, once.curve.correction)
        assert np.array_equal(found.curve.two_sigma, once.curve.two_sigma)


def test_the_page_counts_two_drops_of_one_file_once(log, tmp_path):
    paths = []
    for folder in ("drop1", "drop2"):  # the page has a name of its own for what is dropped
        (tmp_path / folder).mkdir()
        paths.append(write_log(log, tmp_path / folder / "log.csv"))
    files = [NamedFile(path, name) for path, name in zip(paths, ("x.csv", "y.csv"), strict=True)]
    said = []
    for logs in (files[:1], files):
        answer(lambda name, reply: said.append((name, reply)), Request(logs=tuple(logs)), False)
    once, twice = (reply for name, reply in said if name == "answer" and reply.final)
    assert np.array_equal(once.result.curve.correction, twice.result.curve.correction)
    assert twice.flights == ("the same rows are in x.csv and y.csv: the flight counts once",)
    assert [each.name for each in twice.result.provenance.inputs] == ["x.csv", "y.csv"]


def test_two_flights_that_start_alike_are_two(log):
    """Seconds without a date are no clock."""
    other = flown(2)
    found = distinct([log, other], ["a", "b"])
    assert found.logs == (log, other)
    assert not found.notices
    assert not recorders([log, other])


def test_rows_of_an_airplane_at_rest_make_no_two_flights_one(log):
    still = dict.fromkeys(("impact_pressure", "velocity_north", "velocity_east"), 0.0)
    rest = {name: np.full(len(log), value) for name, value in still.items()}
    rest["static_pressure"] = np.full(len(log), 101325.0)
    parked = replace(log, **rest)
    assert len(distinct([parked, replace(parked)], ["a", "b"]).logs) == 2


@pytest.mark.parametrize("dated", [True, False])
@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1)])
def test_the_rows_of_an_overlap_count_once(log, order, dated):
    """Three files of one flight, each from its own first row where they have a date."""
    size, rate = len(log), 10
    pieces = []
    for begin, end in ((0, size // 2), (size // 3, 4 * size // 5), (2 * size // 3, size)):
        piece = log.select(np.arange(begin, end))
        if dated:
            moment = f"2024-05-01 10:{begin // rate // 60:02d}:{begin / rate % 60:06.3f}"
            piece = replace(
                piece, time=piece.time - piece.time[0], header={**log.header, "start": moment}
            )
        pieces.append(piece)
    found = distinct([pieces[n] for n in order], ["a", "b", "c"])
    (whole,) = found.logs
    np.testing.assert_allclose(np.diff(whole.time), np.diff(log.time), atol=1e-6)
    for name in ("impact_pressure", "velocity_north"):
        assert np.array_equal(getattr(whole, name), getattr(log, name))
    (notice,) = found.notices
    assert notice.startswith("the same rows are in a, b and c:")


def test_a_log_that_is_thinned_is_no_second_flight(log):
    thinned = log.select(np.arange(0, len(log), 5))
    for logs in ((log, thinned), (thinned, log)):
        assert distinct(logs, ["a", "b"]).logs == (log,)


@pytest.mark.parametrize(
    ("header", "other", "count"),
    [
        ({"start": START, "airplane": "N1"}, {"start": START, "airplane": "N1"}, 1),
        ({"start": START}, {"start": "2024-05-01T12:00:00+02:00"}, 1),
        ({"start": START, "airplane": "N1"}, {"start": START, "airplane": "N2"}, 0),
        ({"start": START}, {"start": "2024-05-02 10:00:00"}, 0),
        ({"start": "10:00:00"}, {"start": "10:00:00"}, 0),
        ({"start": "2024-05-01"}, {"start": "2024-05-01"}, 0),
    ],
)
def test_two_recorders_are_of_one_airplane_and_one_absolute_clock(log, header, other, count):
    logs = [replace(log, header=header), replace(flown(2), header=other)]
    assert len(recorders(logs)) == count


def recorder(log: FlightLog, seed: int, noise: float, factor: float) -> FlightLog:
    """Another recorder in the same airplane: its own error and noise."""
    rng = np.random.default_rng(seed)
    more = {
        name: getattr(log, name) + rng.normal(0.0, size, len(log))
        for name, size in (
            ("impact_pressure", 20.0 * noise),
            ("velocity_north", noise),
            ("velocity_east", noise),
        )
    }
    more["impact_pressure"] = factor * more["impact_pressure"]
    return replace(log, **more, header={**log.header, "start": START, "airplane": "N1"})


def test_two_recorders_keep_a_curve_each_and_share_the_better_wind(log):
    good, poor = recorder(log, 1, 0.05, 1.0), recorder(log, 2, 0.5, 1.05)
    alone = [calibrate(each) for each in (good, poor)]
    found = calibrate([good, poor])
    middle = len(found[0].curve.correction) // 2
    for each, single in zip(found, alone, strict=True):
        assert "two recorders wrote one flight, log 1 and log 2" in " ".join(each.warnings)
        change = each.curve.correction - single.curve.correction
        assert np.all(np.abs(change) < single.curve.two_sigma)
    apart = found[1].curve.correction[middle] - found[0].curve.correction[middle]
    assert apart < -1.0  # m/s: one of them reads an impact pressure of 5 % more
    for axis in ("north", "east"):
        one, other = (getattr(each.known_wind, axis) for each in found)
        assert one.value == pytest.approx(other.value)
        assert one.two_sigma == pytest.approx(other.two_sigma, rel=0.1)  # of mixtures of two forms
    better = int(np.argmin([np.hypot(*_bounds(each)) for each in alone]))
    assert np.array_equal(found[better].curve.correction, alone[better].curve.correction)
    assert np.array_equal(found[better].curve.two_sigma, alone[better].curve.two_sigma)


def _bounds(found):
    return [getattr(found.known_wind, axis).two_sigma for axis in ("north", "east")]


def test_a_reconciliation_takes_a_flight_once_and_refuses_two_recorders(log, monkeypatch):
    said, judged = list[str](), list[FlightLog]()

    class EnoughError(Exception):
        pass

    def judge_logs(logs, *rest, **more):
        judged.extend(each.log for each in logs)
        raise EnoughError

    monkeypatch.setattr(workflow, "judge_logs", judge_logs)
    with pytest.raises(EnoughError):
        reconcile([log, replace(log)], "none", refly=False, progress=said.append)
    assert judged == [log]
    assert said == ["the same rows are in flight 1 and flight 2: the flight counts once"]
    with pytest.raises(BadInputError, match=r"the same rows .* hold out another"):
        reconcile(log, "none", replace(log), refly=False)
    with pytest.raises(BadInputError, match=r"two recorders wrote one flight.* each alone"):
        reconcile([recorder(log, 1, 0.1, 1.0), recorder(log, 2, 0.1, 1.0)], "none", refly=False)
