"""Signatures, also of a part of the flight, held against what effects do to a log and against brute
force.
"""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench import Case, fly, read_case
from pitotbench.bench.workflow import NamedLog, judge_logs
from pitotbench.reconciliation import renewal as change_points
from pitotbench.reconciliation.clean_track import clean_track
from pitotbench.reconciliation.equations import noise_of_log
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout, lay_out
from pitotbench.reconciliation.patches import patch_of_effects
from pitotbench.reconciliation.signatures import columns_of
from pitotbench.reconciliation.track import track_of
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system
from pitotbench.units import Array


def test_accelerometers_that_shake_are_not_used() -> None:
    """The noise of 3 m/s² would wander by 0.4 m/s within the window, where a fix is known to 0.05
    m/s.
    """
    flight = fly(Case(maneuver="rapid_decel", turbulence="none", truth_seed=4712))

    def with_and_without(noise: float) -> tuple[Array, Array]:
        track = track_of(
            record(flight, replace(data_system("50/10"), acceleration_noise=noise), 4713)
        )
        others = {
            name: values
            for name, values in track.channels.items()
            if not name.startswith("specific_force")
        }
        without = replace(track, channels=others)
        north = [clean_track(each, np.zeros(3))["velocity_north"] for each in (track, without)]
        return north[0], north[1]

    quiet, shaken = with_and_without(0.03), with_and_without(3.0)
    assert np.abs(quiet[0] - quiet[1]).max() > 0.05
    assert np.array_equal(*shaken)


BEGIN, END = 60.0, 180.0


@pytest.fixture(scope="module")
def layout(sensed) -> Layout:
    return lay_out(sensed(das="50/50"), None, AnalysisSetting(day_known=True))


@pytest.mark.parametrize("name", ["gps_latency", "antenna_lever_arm", "static_zero_offset"])
@pytest.mark.parametrize("ends", [True, False])
def test_the_scan_is_that_of_signatures_cut_at_the_times(layout, name, ends):
    """Each signature set to zero outside its part, whitened whole, and fitted with the free
    parameters.
    """
    noise = noise_of_log(layout)
    scan, columns = change_points._Scan(layout, noise), columns_of(layout.signatures)[name]
    begin, end = 3, 8
    cut = np.stack([layout.signatures[c].column for c in columns], axis=2).copy()
    cut[: scan.starts[begin - 1]] = 0.0
    if ends:
        cut[scan.starts[end - 1] :] = 0.0
    whiten = noise.whitener(layout.grid, layout.residuals.slack)
    rows = [whiten(layout.free.columns), whiten(cut), whiten(layout.residuals.values)[:, :, None]]
    free, part, residual = (each.reshape(-1, each.shape[2]) for each in rows)
    widest = np.array([4.0 * abs(layout.parameters[c].typical) for c in columns])

    def misfit(columns: np.ndarray, deviations: np.ndarray) -> float:
        """Least squares with the priors as further rows of data."""
        data = np.concatenate([columns * deviations, np.eye(len(deviations))])
        right = np.concatenate([residual[:, 0], np.zeros(len(deviations))])
        return float(np.sum((right - data @ np.linalg.lstsq(data, right, rcond=1e-13)[0]) ** 2))

    both = np.concatenate([free, part], axis=1)
    expected = misfit(free, layout.free.deviations) - misfit(
        both, np.concatenate([layout.free.deviations, widest])
    )
    found = scan._gains(columns, np.array([begin]), np.array([end]) if ends else None)[0]
    assert found == pytest.approx(expected, rel=1e-4, abs=1e-3)


def test_a_receiver_that_is_late_for_a_time_is_named_with_its_times_and_patched(sensed):
    """Made by hand in the log: for 120 s the velocities are those of 0.5 s before."""
    log = sensed(das="50/50")
    since = log.time - log.time[0]
    late = log.time - np.where((since > BEGIN) & (since < END), 0.5, 0.0)
    moved = {
        name: np.interp(late, log.time, getattr(log, name))
        for name in ("velocity_north", "velocity_east", "velocity_down", "altitude")
    }
    verdict = judge_logs([NamedLog("log", replace(log, **moved))], "none")[1].verdict
    assert verdict.kind in ("named", "one_of")
    found = verdict.effects[0]
    assert found.name == "gps_latency_for_a_time"
    assert found.sizes[0].value == pytest.approx(0.5, abs=found.sizes[0].two_sigma)
    # A lateness does not show while the velocity is steady, so that its begin and end are known to
    # such a stretch.
    begin, end = dict(found.times).values()
    assert (min(end, END) - max(begin, BEGIN)) / (max(end, END) - min(begin, BEGIN)) > 0.7
    patch = patch_of_effects(
        verdict.effects[:1], "flight.csv", "2026-01-01", {found.name: dict(found.times)}
    )
    (entry,) = read_case(patch.text).effects
    assert entry.name == "gps_latency"
    assert entry.parameters["from_s"] == pytest.approx(begin, rel=1e-4)


def test_a_log_without_an_effect_gets_no_part_of_the_flight(layout):
    assert change_points.with_parts_of_flight(layout, noise_of_log(layout)) is layout
