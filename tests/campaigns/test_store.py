"""The store of a campaign: nothing stored is lost, nothing cut is used, and the same command goes
on.
"""

import errno
import json
import os
import shutil
import subprocess
import sys
import time
from dataclasses import replace
from importlib.metadata import Distribution, PackageNotFoundError
from itertools import count
from pathlib import Path

import pandas as pd
import pytest
from tests.campaigns.hard_tasks import Stub, act, stored

from pitotbench import BadInputError, CampaignRequest, Case, __version__, run_campaign
from pitotbench.campaigns import store as store_module
from pitotbench.campaigns.campaign import Watch, fly_missing
from pitotbench.campaigns.fleet import Fleet, FleetLostError
from pitotbench.campaigns.result_table import (
    chosen_rows,
    means,
    result_table,
    write_table,
)
from pitotbench.campaigns.store import ResultStore, StoreError
from pitotbench.cli.app import main

SHORT = Case(
    card={"speeds_kt": [130.0, 110.0], "dwells_s": [10.0, 10.0], "settle_s": 2.0},
    integration_rate=40.0,
)


@pytest.fixture
def store(tmp_path):
    return ResultStore(tmp_path / "store")


def perform(store, tasks, wanted=lambda document, task: True):
    watch = Watch(len(tasks), "none")
    with store:
        fly_missing(tasks, act, stored, store, Fleet(), watch, wanted)
    return watch


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """Two short flights, performed in this process."""
    out = tmp_path_factory.mktemp("short") / "out"
    request = CampaignRequest(
        "decel_circle", "2/1", base=SHORT, seeds=1, out=out, jobs=1, keep_logs="none"
    )
    run_campaign(request)
    run_campaign(replace(request, seeds="2-2"))
    return request


def test_a_checkout_that_is_not_installed_flies_a_campaign(tmp_path, monkeypatch):
    """It has no metadata; the versions of a part are looked up when its flight is over."""
    found = Distribution.from_name

    def lost(name):
        if name == "pitotbench":
            raise PackageNotFoundError(name)
        return found(name)

    monkeypatch.setattr(Distribution, "from_name", lost)
    out = tmp_path / "out"
    run_campaign(
        CampaignRequest("decel_circle", "2/1", base=SHORT, seeds=1, out=out, jobs=1, report=False)
    )
    made = [json.loads(part.read_text())["made"]["versions"] for part in out.rglob("??/*.json")]
    assert [each["pitotbench"] for each in made] == [__version__]


def test_what_is_stored_is_not_performed_again(store, tmp_path):
    tasks = [Stub(f"{n:032x}", notes=str(tmp_path)) for n in range(5)]
    perform(store, tasks[:3])
    watch = perform(store, tasks)
    assert (watch.found, watch.flown) == (3, 2)
    assert len([*tmp_path.glob("0*")]) == 5
    assert [*store.keys()] == [task.key for task in tasks]


def test_a_failure_is_a_result_and_is_performed_again_only_when_asked(store):
    tasks = [Stub("aa", "refuse"), Stub("bb")]
    perform(store, tasks)
    assert store.find("aa")["failures"] == ["aa: ValueError: not flown"]
    assert perform(store, tasks).flown == 0
    assert perform(store, tasks, lambda document, task: document["state"] == "done").flown == 1


@pytest.mark.parametrize(
    "content", [b"", b'{"key": "aa", "na', b"\x00\xff", b'{"key": "bb"}', b"[1]", b"[" * 200_000]
)
def test_a_part_that_is_cut_or_not_of_its_key_is_performed_again(store, content):
    perform(store, [Stub("aa")])
    store.part("aa").write_bytes(content)
    assert store.find("aa") is None
    assert perform(store, [Stub("aa")]).flown == 1
    assert store.find("aa")["state"] == "done"


def test_a_changed_number_a_missing_field_and_another_layout_cost_one_flight_told_in_one_line(
    store, monkeypatch, capsys
):
    tasks = [Stub(f"{number:02d}") for number in range(6)]
    perform(store, tasks)

    def edit(key, change):
        document = json.loads(store.part(key).read_bytes())
        change(document)
        store.part(key).write_text(json.dumps(document))

    edit("00", lambda document: document.update(case="changed"))
    edit("01", lambda document: document.pop("state"))
    edit("02", lambda document: document.pop("checksum"))
    store.part("03").write_bytes(store.part("04").read_bytes())  # whole, but of another key
    monkeypatch.setattr(store_module, "SCHEMA", -1)
    store.put("05", store.find("05") or {"name": "05"}, {})
    monkeypatch.undo()
    watch = perform(store, tasks)
    assert (watch.found, watch.flown) == (1, 5)
    said = capsys.readouterr().err.splitlines()
    assert [
        line.endswith("damaged or incomplete; this flight is flown again") for line in said
    ] == [True] * 5
    assert perform(store, tasks).flown == 0


def test_a_full_disk_stops_with_one_clear_line_and_loses_nothing(store, monkeypatch):
    tasks = [Stub(f"{n:02d}") for n in range(4)]
    whole, calls = os.fsync, count(1)

    def full(descriptor):
        if next(calls) > 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        whole(descriptor)

    monkeypatch.setattr(store_module.os, "fsync", full)
    with pytest.raises(StoreError, match=r"No space left on device; what is stored is whole"):
        perform(store, tasks)
    assert [*store.keys()] == ["00", "01"]
    assert not [*(store.folder / "scratch").iterdir()]
    monkeypatch.undo()
    (store.folder / "scratch" / "aa.json").write_text(
        "{"
    )  # of a driver that was killed as it wrote
    assert (perform(store, tasks).found, [*store.keys()]) == (2, [task.key for task in tasks])
    assert not [*(store.folder / "scratch").iterdir()]


def test_what_the_machine_fails_is_performed_again_and_is_no_result(store, tmp_path):
    gone = [Stub("aa", "lose-once", str(tmp_path)), Stub("bb"), Stub("cc", "lose")]
    with store:
        watch = Watch(3, "none")
        (told,) = fly_missing(gone, act, stored, store, Fleet(), watch)
    assert told == "cc: /gone: No such file or directory; the same command flies it again"
    assert [*store.keys()] == ["aa", "bb"]
    assert (watch.flown, sum(watch.reasons.values())) == (2, 1)
    many = [Stub("bb"), *(Stub(f"{n:02d}", "lose") for n in range(20))]
    with pytest.raises(FleetLostError, match="no worker can work: /gone: No such file"):
        perform(store, many)


def test_a_second_driver_is_refused_and_told_who_writes(store):
    code = (
        "import sys; from pathlib import Path; from pitotbench.campaigns.store import ResultStore\n"
        "try: ResultStore(Path(sys.argv[1])).__enter__()\n"
        "except ValueError as error: print(error)"
    )
    with store:
        said = subprocess.check_output([sys.executable, "-c", code, store.folder], text=True)
    assert "belongs to another campaign that runs now" in said
    assert f"process {os.getpid()}" in said
    # It is free again, also where its owner is dead; a clock set back gives no negative age.
    later = {"host": "old", "process": 1, "since": time.time() + 1e6}
    (store.folder / "owner.json").write_text(json.dumps(later))
    assert store.owner() == "process 1 on old, for 0 min"
    with store:
        pass


def test_the_same_command_again_flies_nothing_and_makes_what_is_damaged_byte_for_byte(campaign):
    request = replace(campaign, seeds=2)
    first = run_campaign(request)
    files = [request.out / "results.parquet", request.out / "report.html"]
    content = [file.read_bytes() for file in files]
    again = run_campaign(request)
    assert (first.found, first.flown, again.found, again.flown) == (2, 0, 2, 0)
    assert [file.read_bytes() for file in files] == content
    assert list(again.table.seed) == [1, 2]
    files[0].write_bytes(content[0][:100])
    files[1].unlink()
    assert run_campaign(request).flown == 0
    assert [file.read_bytes() for file in files] == content


def test_a_flight_without_its_log_is_flown_again_where_logs_are_asked_for(campaign, tmp_path):
    out = tmp_path / "out"
    request = replace(campaign, out=out, report=False)
    run_campaign(request)
    assert not (out / "logs").exists()
    again = run_campaign(replace(request, keep_logs="all"))
    assert again.flown == 1
    assert [path.name for path in (out / "logs").iterdir()] == ["decel_circle-seed1-2_1.parquet"]
    assert run_campaign(replace(request, keep_logs="all")).flown == 0
    (log,) = (out / "store" / "logs").glob("*/*.parquet")
    kept = log.read_bytes()
    log.unlink()  # lost: the flight is flown again, and the campaign goes on
    assert run_campaign(replace(request, keep_logs="all")).flown == 1
    assert log.read_bytes() == kept


def test_results_of_other_code_stay_and_are_not_used(campaign, tmp_path, monkeypatch, capsys):
    request = replace(campaign, out=tmp_path / "out", progress="lines", report=False)
    run_campaign(request)
    for module in ("task", "campaign", "store"):
        monkeypatch.setattr(f"pitotbench.campaigns.{module}.code_digest", lambda: "other")
    assert run_campaign(request).flown == 1
    assert "the stored flights are of other code" in capsys.readouterr().err
    assert len([*ResultStore(request.out / "store").keys()]) == 2


def test_a_cut_index_is_made_again_and_what_else_lies_in_the_store_does_no_harm(
    campaign, tmp_path, capsys
):
    """A stray file or folder among the parts; and a folder in the place of the index is named."""
    out = tmp_path / "out"
    shutil.copytree(campaign.out, out)
    before, index = result_table([out]), out / "store" / "index.parquet"
    index.write_bytes(index.read_bytes()[:200])
    pd.testing.assert_frame_equal(result_table([out]), before)
    assert sorted(before.seed) == [1, 2]
    assert set(before["das.gps_rate_hz"]) == {1.0}
    assert len(result_table([out, out])) == 2  # each flight once
    parts = out / "store" / "flights"
    (parts / "aa").mkdir(exist_ok=True)
    for stray in (parts / "notes.txt", parts / "aa" / "notes.txt"):
        stray.write_text("mine")
    (parts / "aa" / "aa.json").write_text('{"key": "aa", "rows": null}')
    found = result_table([out])
    assert len(found) == len(before) + 1
    assert set(found.state) == {"done", "damaged"}
    index.unlink()
    index.mkdir()
    assert main(["results", str(out)]) == 2
    assert "index.parquet: " in capsys.readouterr().err


def test_an_edited_index_is_made_again(campaign, tmp_path, capsys):
    out = tmp_path / "out"
    shutil.copytree(campaign.out, out)
    before, index = result_table([out]), out / "store" / "index.parquet"
    for edited in (before.assign(two_sigma_kt=0.001), before.drop(columns="two_sigma_kt")):
        edited.to_parquet(index, index=False)
        pd.testing.assert_frame_equal(result_table([out]), before)
        assert "it is made again from the 2 parts" in capsys.readouterr().err
    result_table([out])
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("late", [0, 1])
def test_of_a_flight_that_came_later_its_own_part_alone_is_read(
    late, campaign, tmp_path, monkeypatch
):
    out = tmp_path / "out"
    shutil.copytree(campaign.out, out)
    whole, store = result_table([out]), ResultStore(out / "store")
    key = [*store.keys()][late]
    kept = store.part(key).rename(tmp_path / "part")
    assert {*result_table([out]).flight} == {*whole.flight} - {key}  # what is gone is left out
    kept.rename(store.part(key))
    read, find = [], ResultStore.find
    monkeypatch.setattr(ResultStore, "find", lambda self, key: read.append(key) or find(self, key))
    pd.testing.assert_frame_equal(result_table([out]), whole)
    assert read == [key]


@pytest.mark.parametrize("wrong", [{"rows": None}, {"rows": [{"maneuver": 1}]}, {"made": []}])
def test_a_part_of_a_wrong_shape_that_was_sealed_by_hand_costs_one_flight(
    wrong, campaign, tmp_path, capsys
):
    out = tmp_path / "out"
    shutil.copytree(campaign.out, out)
    store = ResultStore(out / "store")
    key = next(store.keys())
    text = json.dumps({**store.find(key), **wrong}, allow_nan=True)[:-1].encode()
    store.part(key).write_bytes(text + store_module._seal(text))
    assert store.find(key) is None
    assert main(["results", str(out)]) == 0
    assert "1 damaged" in capsys.readouterr().out
    again = run_campaign(replace(campaign, seeds=2, out=out, report=False))
    assert (again.found, again.flown) == (1, 1)


def test_a_pipe_in_the_place_of_a_part_or_of_the_owner_is_replaced(store):
    perform(store, [Stub("aa")])
    for path in (store.part("aa"), store.folder / "owner.json"):
        path.unlink()
        os.mkfifo(path)
    assert store.find("aa") is None
    assert perform(store, [Stub("aa")]).flown == 1
    assert store.find("aa")["state"] == "done"


def test_a_lock_of_garbage_names_the_file_to_delete(store):
    perform(store, [Stub("aa")])
    (store.folder / "lock.sqlite").write_bytes(b"no database, but longer than its header" * 9)
    with pytest.raises(StoreError, match=r"lock\.sqlite: cannot be locked.*delete it"):
        perform(store, [Stub("aa")])
    (store.folder / "lock.sqlite").unlink()
    assert perform(store, [Stub("aa")]).found == 1


def test_a_text_that_a_spreadsheet_takes_for_a_formula_is_text(campaign, tmp_path):
    table = result_table([campaign.out]).assign(calibration=["=1+1|cmd", "@SUM(A1)"])
    table = table.rename(columns={"reason": "+reason"}).assign(wind_error_kt=-1.0)
    write_table(table, tmp_path / "all.csv")
    found = pd.read_csv(tmp_path / "all.csv")
    assert found.calibration.tolist() == ["'=1+1|cmd", "'@SUM(A1)"]
    assert "'+reason" in found.columns
    assert found.wind_error_kt.tolist() == [-1.0, -1.0]
    assert found.turbulence.tolist() == table.turbulence.tolist()


def test_a_campaign_of_failures_alone_lists_names_and_reasons(tmp_path, capsys):
    out = tmp_path / "out"
    plan = tmp_path / "plan.toml"
    plan.write_text('das = ["2/1"]\n[case]\nmaneuver = "decel_circle"\naltitude_ft = 90000\n')
    assert main(["campaign", str(plan), "--out", str(out), "--jobs", "1"]) == 3
    said = capsys.readouterr().err
    assert "no flight gave a result: decel_circle-seed1: " in said
    for more in ([], ["--state", "failed"], ["--by", "state"]):
        assert main(["results", str(out), *more]) == 0
    listed = capsys.readouterr().out
    assert "decel_circle-seed1" in listed
    assert said.partition("decel_circle-seed1: ")[2][:30].strip() in listed


def test_shards_become_one_table_that_readers_of_parquet_open(campaign, tmp_path):
    parts = [tmp_path / f"part-{k}" for k in (1, 2)]
    for k, out in enumerate(parts, start=1):
        run_campaign(replace(campaign, seeds="1-2", shard=(k, 2), out=out, report=False))
    whole = tmp_path / "all.parquet"
    assert main(["results", *map(str, parts), "--out", str(whole)]) == 0
    table = pd.read_parquet(whole)
    assert sorted(table.seed) == [1, 2]
    opened = pd.read_parquet(whole, filters=[("seed", "==", 2)], columns=["two_sigma_kt"])
    assert opened.two_sigma_kt.tolist() == table[table.seed == 2].two_sigma_kt.tolist()
    numbers = ["two_sigma_kt", "curve_rms_error_kt", "wind_error_kt", "minutes"]
    alone = result_table([campaign.out]).set_index("flight")
    pd.testing.assert_frame_equal(
        table.set_index("flight")[numbers], alone.loc[table.flight, numbers]
    )


def test_rows_are_chosen_and_averaged(campaign):
    table = result_table([campaign.out])
    assert list(chosen_rows(table, "seed == 2", "done").seed) == [2]
    assert means(table, ["maneuver"]).rows.tolist() == [2]
    asked = "`das.gps_rate_hz` == 1 and not seed in [1, 3] and seed / 2 < 2"
    assert list(chosen_rows(table, asked, None).seed) == [2]


@pytest.mark.parametrize(
    "wrong",
    [
        "seed ==",
        "@table",
        "no_column > 1",
        "__import__('os')",
        "name.to_csv('written.csv') == 1",
        "'`' == name.to_csv('written.csv') or '`' == ''",
        "[each for each in name]",
        "name[0] == 1",
    ],
)
def test_a_condition_that_is_none_is_refused_and_runs_nothing(
    wrong, campaign, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadInputError, match="--where"):
        chosen_rows(result_table([campaign.out]), wrong, None)
    assert not [*tmp_path.iterdir()]


def test_results_are_listed_drawn_and_written(campaign, tmp_path, capsys):
    assert main(["results", str(campaign.out), "--by", "maneuver"]) == 0
    assert "2 rows of 2 flights: 2 done" in capsys.readouterr().out
    assert main(["results", str(campaign.out), "--out", str(tmp_path / "all.csv")]) == 0
    assert len(pd.read_csv(tmp_path / "all.csv")) == 2
    picture = tmp_path / "bound.svg"
    assert (
        main(
            ["results", str(campaign.out), "--draw", "two_sigma_kt,minutes", "--out", str(picture)]
        )
        == 0
    )
    assert picture.read_text(encoding="utf-8").startswith("<svg")
    assert main(["results", str(campaign.out), "--columns", "tow_sigma_kt"]) == 2
    assert "two_sigma_kt" in capsys.readouterr().err


def test_a_stored_flight_is_flown_again_bit_for_bit_and_a_changed_number_is_found(
    campaign, capsys, tmp_path
):
    name, page = "decel_circle-seed2", str(tmp_path / "page.html")
    again = ["results", str(campaign.out), "--page", name, "--out", page]
    assert main(again) == 0
    assert "the same bit for bit" in capsys.readouterr().out
    store = ResultStore(campaign.out / "store")
    keys = [*store.keys()]
    part = store.part(next(key for key in keys if store.find(key)["name"] == name))
    kept, document = part.read_bytes(), store.find(part.stem)
    document["rows"][0]["score"]["two_sigma"] *= 1.0 + 1e-9
    store.put(part.stem, document, {})
    assert main(again) == 3
    part.write_bytes(kept)
    differs = [line for line in capsys.readouterr().out.splitlines() if "differs" in line]
    assert len(differs) == 1
    assert "two_sigma_kt" in differs[0]
    assert main(["results", str(campaign.out), "--page", "nothing", "--out", page]) == 2


def test_a_folder_of_something_else_is_refused(tmp_path):
    (tmp_path / "thesis.txt").write_text("mine")
    with pytest.raises(BadInputError, match="holds no campaign's results"):
        run_campaign(CampaignRequest("circle", "20/1", out=tmp_path))
    with pytest.raises(BadInputError, match="holds no stored results"):
        result_table([tmp_path])


def test_a_watch_counts_reports_once_a_minute_and_knows_the_time_left(capsys):
    now = [0.0]
    watch = Watch(100, "json", clock=lambda: now[0])
    for number in range(50):
        now[0] += 2.0
        watch.fly("no answer" if number % 10 == 0 else "")
    lines = [json.loads(line) for line in capsys.readouterr().err.splitlines()]
    assert [line["flown"] for line in lines] == [30]
    assert lines[0]["flights_per_s"] == pytest.approx(0.5)
    assert lines[0]["left_s"] == 140
    assert lines[0]["reasons"] == {"no answer": 3}
    assert watch.line() == "50 of 100 flights, 0.50 a second, 2 min left, failed: 5 × no answer"
    assert Watch(10, "none").rate == 0.0


def test_sigterm_stops_a_campaign_and_names_the_command_that_goes_on(tmp_path):
    plan, out = tmp_path / "short.toml", tmp_path / "out"
    plan.write_text(
        'das = ["2/1"]\nseeds = "2000"\n[case]\nmaneuver = "decel_circle"\nintegration_rate_hz = 40\n'
        "card = {speeds_kt = [130, 110], dwells_s = [10, 10], settle_s = 2}\n"
    )
    command = [
        sys.executable,
        *["-m", "pitotbench", "campaign", "--jobs", "1", "--out"],
        str(out),
        str(plan),
    ]
    settings = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2] / "src")}
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=settings) as driver:
        while driver.poll() is None and not [*(out / "store/flights").glob("*/*.json")]:
            time.sleep(0.05)
        driver.terminate()
        said = driver.communicate(timeout=60)[1]  # the plan would take minutes
    assert driver.returncode == 130
    assert said.startswith("pitotbench: stopped (SIGTERM); ")
    assert f"to go on: pitotbench campaign --jobs 1 --out {out} {plan}" in said.splitlines()[-1]
