"""Flights that many tests look at, each flown once a run and only if asked for."""

import os
import pickle
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
from hypothesis import settings
from scipy import linalg  # noqa: F401 - its BLAS is loaded before the threads are limited
from threadpoolctl import threadpool_limits

from pitotbench import CalibrationOptions, Case, Flight, FlightLog, calibration, fly
from pitotbench.broken import Broken
from pitotbench.calibration.flights import CalibratedFlight
from pitotbench.logbook import checks
from pitotbench.simulation.maneuvers import MANEUVERS

settings.register_profile("untimed", deadline=None)  # a busy machine is no defect
settings.load_profile("untimed")
os.environ["PITOTBENCH_CONFIG"] = os.devnull  # no test reads the configuration of who runs it


def pytest_report_teststatus(report: pytest.TestReport) -> tuple[str, str, str] | None:
    """Name in pytest's closing line what was not compared, apart from what is skipped for other
    reasons.
    """
    if report.skipped and "::test_light_turbulence[" in report.nodeid:
        return "not compared in simulated light air", "s", "NOT COMPARED"
    return None


# The files that take longest, by the CPU seconds of one process and of those that it starts, the
# longest first.
LONGEST = (
    "tests/lab/recovery/test_causes.py",
    "tests/lab/test_house_reach.py",
    "tests/lab/test_checklists.py",
    "tests/lab/recovery/test_vanes.py",
    "tests/lab/test_long_pages_run.py",
    "tests/lab/test_two_sigma_of_others.py",
    "tests/lab/test_blind.py",
    "tests/lab/recovery/test_several_flights.py",
    "tests/lab/test_patched_effects.py",
    "tests/lab/test_mistakes.py",
    "tests/lab/recovery/test_null_distribution.py",
    "tests/lab/test_both_ends.py",
    "tests/lab/test_spoil.py",
    "tests/lab/recovery/test_cards_flown_again.py",
    "tests/lab/recovery/test_formulas.py",
    "tests/lab/recovery/test_subtracted_effects.py",
    "tests/lab/recovery/test_aircraft_files.py",
    "tests/lab/study/test_claims.py",
    "tests/lab/recovery/test_broken_pitots_in_files.py",
    "tests/lab/recovery/test_owners_folder.py",
    "tests/lab/study/test_report.py",
    "tests/lab/study/test_flying.py",
    "tests/logbook/test_field_kinds.py",
    "tests/cli/test_one_answer.py",
    "tests/simulation/test_sortie.py",
    "tests/cli/test_refusals.py",
    "tests/test_pages_run.py",
    "tests/logbook/test_field_cases.py",
    "tests/lab/recovery/test_closing.py",
    "tests/reconciliation/test_naming.py",
    "tests/campaigns/test_campaign.py",
    "tests/campaigns/test_store.py",
    "tests/campaigns/test_flights.py",
    "tests/simulation/test_effects_flown.py",
    "tests/lab/recovery/test_terms.py",
    "tests/show/test_gap_report.py",
    "tests/cli/test_several_flights.py",
    "tests/logbook/test_drafting.py",
    "tests/calibration/test_priors.py",
    "tests/logbook/test_bad_logs.py",
    "tests/bench/test_planner.py",
    "tests/browser/test_in_chromium.py",
    "tests/logbook/test_foreign_files.py",
    "tests/simulation/test_force_meter.py",
    "tests/calibration/test_long_flights.py",
    "tests/calibration/test_broken_pitots.py",
    "tests/cli/test_cli.py",
    "tests/logbook/test_real_logs.py",
    "tests/lab/recovery/test_path_flow.py",
)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put the longest files first: a worker then ends a run with short ones, and none waits long for
    the other.
    """
    places = {config.rootpath / name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: places.get(item.path, len(places)))


@pytest.fixture(scope="session", autouse=True)
def one_process() -> Iterator[None]:
    """What takes a process or a thread for each processor takes one: each worker of the tests has a
    core.
    """
    with pytest.MonkeyPatch.context() as patch, threadpool_limits(limits=1):
        patch.setattr("os.cpu_count", lambda: 1)
        patch.setattr("os.sched_getaffinity", lambda process: {0}, raising=False)
        yield


def _digest(told: object) -> bytes:
    written = BytesIO()
    pickler = pickle.Pickler(written)
    pickler.dispatch_table = {MappingProxyType: lambda held: (dict, (dict(held),))}
    pickler.dump(told)
    return sha256(written.getbuffer()).digest()


@pytest.fixture(scope="session", autouse=True)
def one_search_of_each_log() -> Iterator[None]:
    """A log that is searched again for a broken pitot has the first answer, which its channels alone
    decide: the search is a sixth of reading one, and most tests read a log that others read.
    """
    find, kept = checks.find_early, dict[bytes, Broken | None]()

    def found(channels: Mapping[str, Any]) -> Broken | None:
        told = sha256()
        for name in sorted(channels):  # without a copy: some tests look at the memory
            told.update(name.encode())
            told.update(np.ascontiguousarray(channels[name]))
        key = told.digest()
        if key not in kept:
            kept[key] = find(channels)
        return kept[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(checks, "find_early", found)
        yield


@pytest.fixture(scope="session")
def kept_fits() -> dict[bytes, tuple[CalibratedFlight, ...]]:
    """The answers of the logs that were fitted, by the digest of log and options."""
    return {}


@pytest.fixture(scope="module")
def one_fit_of_each_log(kept_fits: dict[bytes, tuple[CalibratedFlight, ...]]) -> Iterator[None]:
    """A log that is fitted again with the same options has the first answer.

    For modules that look at what is said of an answer, in one voice after the other. A log is the
    same where its rows and its header are, bit for bit.
    """
    fit, kept = calibration.calibrate_flights, kept_fits

    def fitted(
        logs: Sequence[FlightLog], options: CalibrationOptions | None = None, *more: Any
    ) -> tuple[CalibratedFlight, ...]:
        if any(each is not None for each in more):
            return fit(logs, options, *more)
        key = _digest([list(logs), options])
        if key not in kept:
            kept[key] = fit(logs, options)
        return kept[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(calibration, "calibrate_flights", fitted)
        yield


class Flights(Mapping[str, Flight]):
    """Maneuver name to its flight in one turbulence, flown on first use.

    The workers of a run share `folder`: what one has flown, the others read.
    """

    def __init__(self, turbulence: str, folder: Path) -> None:
        self.turbulence = turbulence
        self.folder = folder
        self._flown: dict[str, Flight] = {}

    def __getitem__(self, maneuver: str) -> Flight:
        if maneuver not in self._flown:
            file = self.folder / f"{self.turbulence}-{maneuver}.pickle"
            with suppress(FileNotFoundError):
                self._flown[maneuver] = Flight(*pickle.loads(file.read_bytes()))
        if maneuver not in self._flown:
            flight = fly(Case(maneuver=maneuver, turbulence=self.turbulence))
            kept = (flight.case, dict(flight.channels), flight.segment, flight.on_condition)
            part = file.with_suffix(f".{os.getpid()}")
            part.write_bytes(pickle.dumps(kept))
            part.replace(file)
            self._flown[maneuver] = flight
        return self._flown[maneuver]

    def __iter__(self) -> Iterator[str]:
        return iter(MANEUVERS)

    def __len__(self) -> int:
        return len(MANEUVERS)


@pytest.fixture(scope="session")
def shared_folder(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> Iterator[Path]:
    """A folder that all workers of a run share."""
    own = tmp_path_factory.getbasetemp()
    folder = (own if worker_id == "master" else own.parent) / "flights"
    folder.mkdir(exist_ok=True)
    yield folder
    for file in folder.glob("*.pickle"):  # gigabytes; who still wants one flies it
        file.unlink(missing_ok=True)


@pytest.fixture(scope="session")
def smooth_flights(shared_folder: Path) -> Flights:
    """Every maneuver in 15 kt of wind without turbulence."""
    return Flights("none", shared_folder)


@pytest.fixture(scope="session")
def light_flights(shared_folder: Path) -> Flights:
    """Every maneuver in 15 kt of wind and light turbulence."""
    return Flights("light", shared_folder)
