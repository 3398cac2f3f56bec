"""A spectral line is an unknown of the log: it leaves the name of an effect, and is told beside it."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench import Case, fly, sense
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout, lay_out, without_vane_errors
from pitotbench.reconciliation.lines import spectral_lines, with_lines
from pitotbench.reconciliation.null_distribution import (
    Measure,
    NullDistribution,
    theoretical_distribution,
)
from pitotbench.reconciliation.verdict import judge
from pitotbench.records.case import EffectSpec

PERIOD = 41.0  # s


@pytest.fixture(scope="module")
def laid_out() -> Layout:
    """A flight with a pod that the model lacks, laid out for a few hypotheses."""
    pod = EffectSpec("belly_pod", {"drag_area_m2": 0.12})
    few = Catalog("effect", {name: EFFECTS[name] for name in ("belly_pod", "mass", "humid_air")})
    log = sense(fly(Case(maneuver="rapid_decel", truth_seed=21, effects=(pod,))), "20/20")
    return lay_out(log, aircraft_model("navajo"), AnalysisSetting(day_known=True), few)


@pytest.fixture(scope="module")
def null(laid_out: Layout) -> NullDistribution:
    """Null flights with the lines of that flight and no others."""
    own = theoretical_distribution(laid_out)
    lines = spectral_lines(laid_out, own.noise)
    usual = {name: Measure(line.log_ratio, 0.3) for name, line in lines.items()}
    return replace(own, spectral_lines=usual)


def with_wave(layout: Layout, channel: str, kelvin: float) -> Layout:
    values = layout.residuals.values.copy()
    time = layout.track.time[layout.grid.rows]
    values[:, layout.residuals.names.index(channel)] += kelvin * np.sin(2 * np.pi * time / PERIOD)
    return replace(layout, residuals=replace(layout.residuals, values=values))


def test_a_line_is_found_in_its_own_channel_at_its_period(laid_out, null) -> None:
    (line,) = with_lines(with_wave(laid_out, "temperature", 0.8), null).lines
    assert line.channel == "temperature"
    assert line.period == pytest.approx(PERIOD, rel=0.03)


def test_without_a_line_nothing_is_freed(laid_out, null) -> None:
    assert with_lines(laid_out, null) is laid_out


def test_a_line_leaves_the_name_of_an_effect_and_is_told_beside_it(laid_out, null) -> None:
    plain = judge(["flight"], [laid_out], [null]).verdict
    verdict = judge(["flight"], [with_wave(laid_out, "temperature", 0.8)], [null]).verdict
    assert [effect.name for effect in verdict.effects] == ["belly_pod"]
    (size,), (alone,) = (v.effects[0].sizes for v in (verdict, plain))
    assert abs(size.value - alone.value) < 0.2 * alone.two_sigma
    assert verdict.remains
    assert any(p.channel == "temperature" and "period" in p.where for p in verdict.located)


def test_a_line_alone_gets_no_name(laid_out, null) -> None:
    sound = laid_out.without(
        [s.column for s in laid_out.signatures if s.effect == "belly_pod"], [0.12]
    )
    verdict = judge(["flight"], [with_wave(sound, "temperature", 0.8)], [null]).verdict
    assert verdict.kind == "unknown"
    assert verdict.effects == ()


def test_a_layout_along_another_track_keeps_its_lines(laid_out, null) -> None:
    freed = with_lines(with_wave(laid_out, "temperature", 0.8), null)
    moved = without_vane_errors(freed, {"angle_of_attack bias": 0.02, "angle_of_attack scale": 0.0})
    assert moved is not freed
    assert moved.lines == freed.lines
    assert set(freed.free.names) == set(moved.free.names)
