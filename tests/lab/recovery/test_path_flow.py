"""Logs without vanes and without a mass: the angles of the flow are those of the path."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d

from pitotbench.axes import body_to_earth, earth_to_body
from pitotbench.bench.inspection import inspect_log
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.fitting import fit_gaps
from pitotbench.reconciliation.flight_path import PATH_SCALES, WIND, flow_angles, with_path_flow
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out, mean_wind_of
from pitotbench.reconciliation.null_distribution import theoretical_distribution
from pitotbench.reconciliation.track import FORCES, track_of
from pitotbench.reconciliation.verdict import may_be_gusts
from pitotbench.records.case import Case, DataSystem, Wind
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import record
from pitotbench.simulation.sortie import fly
from pitotbench.units import DEGREE

BARE = dict.fromkeys(("angle_of_attack", "sideslip", "mass"))
SHOWN = ("pitch_stiffness", "lift_slope", "mass", "belly_pod")
FEW = Catalog("effect", {name: EFFECTS[name] for name in SHOWN})


@pytest.fixture(scope="module")
def log() -> FlightLog:
    """A circle of the c172x in calm air, 15 m/s of wind from the west."""
    das = DataSystem(20.0, 5.0, vane_noise=0.0)
    case = Case("c172x", "circle", wind=Wind(15.0, 0.5 * np.pi), turbulence="none", das=das)
    return record(fly(case), das, 1)


@pytest.fixture(scope="module")
def start(log: FlightLog) -> FlightLog:
    """Its first two minutes, a turn: enough to say what is compared."""
    return log.part(log.time < log.start + 120.0)


def test_earth_to_body_undoes_body_to_earth() -> None:
    """Vectors come back."""
    draw = np.random.default_rng(1)
    vector, angles = draw.normal(size=(3, 50)), draw.uniform(-1.5, 1.5, (3, 50))
    back = earth_to_body(body_to_earth(vector, *angles), *angles)
    assert np.allclose(back, vector, atol=1e-12)


def test_in_calm_air_the_path_gives_the_angles_of_the_vanes(log: FlightLog) -> None:
    """The vanes of the same flight are the oracle."""
    vanes = track_of(log)
    bare = track_of(replace(log, header={}, **BARE))
    wind = mean_wind_of(vanes, np.ones(len(vanes.time), dtype=bool))
    path = flow_angles(with_path_flow(bare, wind, 1000.0))
    for one, other in zip(path, flow_angles(vanes), strict=True):
        off = np.abs(uniform_filter1d(one - other, 40))  # 2 s: the attitude has noise
        # Beyond it are the ends of the circles, where the filters end.
        assert np.quantile(off, 0.8) < 0.15 * DEGREE


def test_only_quick_changes_of_the_path_have_a_scale(log: FlightLog) -> None:
    """Gusts and the answers to them last seconds; what follows the airspeed is whole."""
    bare = track_of(replace(log, header={}, **BARE))
    plain = with_path_flow(bare, mean_wind_of(bare, np.ones(len(bare.time), dtype=bool)), 1000.0)
    swaying = plain.replaced({"pitch": plain["pitch"] + 0.01 * np.sin(2.0 * plain.time)})
    for track, least, most in ((plain, 0.0, 0.004), (swaying, 0.006, 0.009)):
        scaled = track.replaced(dict.fromkeys(PATH_SCALES, np.ones(len(track.time))))
        moved = flow_angles(scaled)[0] - flow_angles(track)[0]
        slow = uniform_filter1d(moved, round(40.0 / track.row_period))
        assert least < np.std(moved) < most
        assert np.quantile(np.abs(slow), 0.9) < 0.001


def test_forces_are_compared_without_vanes_and_mass(start: FlightLog) -> None:
    """The force meter follows the path, at the mass of the loaded model."""
    model = aircraft_model("c172x")
    assert model is not None
    laid = lay_out(replace(start, header={}, **BARE), model, AnalysisSetting(), FEW)
    assert {*FORCES, "pitch_acceleration", "airspeed_along"} <= set(laid.residuals.names)
    assert "airspeed_across" not in laid.residuals.names  # the path gives its direction itself
    assert np.all(laid.track["mass"] == model.mass)
    assert {s.effect for s in laid.signatures} == set(SHOWN)


def test_a_log_with_vanes_has_no_channels_of_a_path(start: FlightLog) -> None:
    """What is measured is used."""
    model = aircraft_model("c172x")
    laid = lay_out(start, model, AnalysisSetting(), FEW)
    assert not {*WIND} & set(laid.track.channels)
    assert "airspeed_across" in laid.residuals.names


def test_without_controls_the_sensors_alone_keep_their_channels(log: FlightLog) -> None:
    """No path is laid where no force follows from it."""
    model = aircraft_model("c172x")
    bare = replace(log, header={}, elevator=None, **BARE)
    laid = lay_out(bare, model, AnalysisSetting())
    assert not {*WIND} & set(laid.track.channels)
    assert "airspeed_across" in laid.residuals.names


def test_the_account_of_a_log_says_what_reconcile_needs(log: FlightLog) -> None:
    """Neither vanes nor a mass, but the controls."""

    def answered(each: FlightLog) -> bool:
        told = {question.name: question.answered for question in inspect_log(each).questions}
        return told["reconciliation with a model"]

    assert answered(replace(log, header={}, **BARE))
    assert not answered(replace(log, header={}, elevator=None))


def test_rising_air_is_no_cause_where_only_the_lift_would_show_it(start: FlightLog) -> None:
    """On logs without vanes it stood for what the form of another lift slope leaves open."""
    both = Catalog("effect", {name: EFFECTS[name] for name in ("updraft", "lift_slope")})
    layout = lay_out(replace(start, **BARE), aircraft_model("c172x"), AnalysisSetting(), both)
    assert {each.effect for each in layout.signatures} == {"lift_slope"}


def test_without_vanes_a_lighter_airplane_is_one_of_mass_and_lift(start: FlightLog) -> None:
    """The rest that the prediction leaves in each force decides nothing between them; with vanes
    the log does.
    """
    alike = ("mass", "lift_slope", "zero_lift")
    every = Catalog("effect", {name: EFFECTS[name] for name in alike})
    model = aircraft_model("c172x")
    assert model is not None
    light = replace(model, mass=1.2 * model.mass)  # of the sheet: the airplane is lighter than it
    layout = lay_out(replace(start, header={}, **BARE), light, AnalysisSetting(), every)
    (gap, *_) = fit_gaps([layout], [theoretical_distribution(layout)]).gaps
    assert gap.causes["mass"] == gap.causes["lift_slope"] == gap.causes["zero_lift"] > 0.3


def test_without_vanes_and_null_flights_gusts_may_make_a_moment(start: FlightLog) -> None:
    """The controls answer a gust that nobody measured, as they would another moment."""
    one, model = Catalog("effect", {"trim_offset": EFFECTS["trim_offset"]}), aircraft_model("c172x")
    told = []
    for log, counts in ((replace(start, **BARE), (0, 8)), (start, (0,))):
        layout = lay_out(replace(log, header={}), model, AnalysisSetting(), one)
        moved = layout.without([layout.signatures[0].column], [-0.05])
        for flights in counts:
            fitted = fit_gaps([moved], [replace(theoretical_distribution(moved), flights=flights)])
            gap = next(each for each in fitted.gaps if each.member.name == "trim_offset")
            told.append(may_be_gusts(fitted, gap))
    assert told == [True, False, False]
