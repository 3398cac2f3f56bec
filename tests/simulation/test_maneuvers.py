"""Cards, and maneuvers flown as their cards say, in the paper's time (Martos et al. 2011, Table 2)."""

import re

import numpy as np
import pytest

from pitotbench import BadInputError, Case, Flight, UnknownNameError
from pitotbench.simulation.card import override
from pitotbench.simulation.maneuvers import MANEUVERS, PAPER_MANEUVERS
from pitotbench.simulation.sortie import fly
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT


def on_kind(flight: Flight, maneuver: str) -> np.ndarray:
    return np.char.startswith(flight.segment, MANEUVERS[maneuver].kind + " ")


def labels(flight: Flight) -> list[str]:
    """The segments in order, each once a run."""
    change = np.flatnonzero(flight.segment[1:] != flight.segment[:-1]) + 1
    return [str(flight.segment[i]) for i in np.concatenate(([0], change))]


def turned(angle: np.ndarray) -> np.ndarray:
    return (angle + np.pi) % (2 * np.pi) - np.pi


@pytest.mark.parametrize("name", PAPER_MANEUVERS)
def test_time_is_the_papers(name, smooth_flights):
    minutes = len(smooth_flights[name]) / 6000
    assert minutes == pytest.approx(MANEUVERS[name].minutes, rel=0.10)


@pytest.mark.parametrize("name", MANEUVERS)
def test_smooth_air_is_on_condition_throughout_and_light_turbulence_mostly(
    name, smooth_flights, light_flights
):
    flight, light = smooth_flights[name], light_flights[name]
    kind = on_kind(flight, name)
    assert kind.any()
    assert flight.on_condition[kind].mean() > 0.999
    assert not np.char.startswith(flight.segment, "turn")[flight.on_condition].any()
    assert light.on_condition[on_kind(light, name)].mean() > 0.90


@pytest.mark.parametrize("name", MANEUVERS)
def test_on_condition_samples_are_inside_the_cards_tolerances(name, smooth_flights):
    """Sample by sample, against the speed and heading that the segment's label names."""
    flight, card = smooth_flights[name], MANEUVERS[name].card
    for label in labels(flight):
        on = flight.on_condition & (flight.segment == label)
        if not on.any():
            continue
        assert (
            np.abs(flight["altitude"][on] - flight.case.altitude).max() <= card.altitude_tolerance
        )
        speed = re.match(r"\S+ (\d+) kt", label)
        if speed and "airspeed" in MANEUVERS[name].judged:
            error = flight["calibrated_airspeed"][on] - float(speed[1]) * KNOT
            assert np.abs(error).max() <= card.airspeed_tolerance
        if "heading" in MANEUVERS[name].judged:
            heading = re.search(r"(\d+)°", label)
            error = turned(flight["heading"][on] - (float(heading[1]) * DEGREE if heading else 0.0))
            assert (
                np.minimum(np.abs(error), np.abs(turned(error + np.pi))).max()
                <= card.heading_tolerance
            )


def test_segments_of_legs(smooth_flights):
    seen = labels(smooth_flights["four_leg"])
    assert len(seen) == 4 * 12
    assert seen[:3] == ["leg 160 kt 000°", "turn 160 kt 090°", "settle 160 kt 090°"]
    assert [s for s in seen if s.startswith("leg 100")] == [
        f"leg 100 kt {h:03d}°" for h in (0, 90, 180, 270)
    ]
    legs = [s for s in labels(smooth_flights["race_track"]) if s.startswith("leg")]
    assert legs == [f"leg {v} kt {h:03d}°" for v in (160, 140, 120, 100) for h in (0, 180)]


@pytest.mark.parametrize(
    ("name", "edges"),
    [
        ("step_decrease", (160, 130, 100)),
        ("rapid_decel", (160, 100)),
        ("step_both_ways", (160, 100)),
    ],
)
def test_decelerations_span_their_speeds_on_reciprocal_headings(name, edges, smooth_flights):
    flight = smooth_flights[name]
    kind = on_kind(flight, name)
    speed = flight["calibrated_airspeed"] / KNOT
    assert speed[kind].max() == pytest.approx(max(edges), abs=1.0)
    assert speed[kind].min() == pytest.approx(min(edges), abs=1.0)
    for heading in (0.0, np.pi):
        one = kind & (np.abs(turned(flight["heading"] - heading)) < 2 * DEGREE)
        assert one.sum() > 1000
        if name == "step_both_ways":  # every speed on both
            assert speed[one].max() > 155.0
            assert speed[one].min() < 101.0


def test_step_decrease_takes_power_off_one_inch_at_a_time(smooth_flights):
    flight = smooth_flights["step_decrease"]
    steps = [s for s in labels(flight) if s.startswith("step")]
    inches = np.array([float(s.split()[2]) for s in steps])
    down = np.diff(inches)
    assert len(steps) > 12
    assert (
        np.isclose(down, -1.0, atol=0.11).sum() == len(down) - 1
    )  # but for the turn, where power is added


def test_circle_turns_full_circles_at_thirty_degrees(smooth_flights):
    flight = smooth_flights["circle"]
    for speed in (160, 140, 120, 100):
        one = np.char.startswith(flight.segment, f"circle {speed} ")
        total = np.unwrap(flight["heading"][one])
        assert total[-1] - total[0] == pytest.approx(2 * np.pi, abs=2 * DEGREE)
        assert np.median(flight["roll"][one]) == pytest.approx(30 * DEGREE, abs=1 * DEGREE)


@pytest.mark.parametrize("name", MANEUVERS)
def test_turns_go_right_and_never_too_steep(name, smooth_flights):
    flight = smooth_flights[name]
    turning = np.char.startswith(flight.segment, "turn")
    if turning.any():
        assert flight["roll"][turning].min() > -5 * DEGREE
    assert np.abs(flight["roll"]).max() < max(
        38 * DEGREE, MANEUVERS[name].card.bank_limit + 5 * DEGREE
    )
    planned = getattr(MANEUVERS[name].card, "climb", 0.0)
    height = flight["altitude"] - flight.case.altitude
    assert height.min() > -60 * FOOT
    assert height.max() < planned + 60 * FOOT


def test_all_means_the_five_of_the_paper():
    assert PAPER_MANEUVERS == ("four_leg", "race_track", "step_decrease", "rapid_decel", "circle")
    assert set(MANEUVERS) - set(PAPER_MANEUVERS) >= {
        "step_both_ways",
        "decel_circle",
        "figure_eight",
        "cloverleaf",
    }


@pytest.mark.parametrize("name", ["decel_circle", "figure_eight", "cloverleaf"])
def test_slowing_down_in_the_turn_needs_no_set_up(name, smooth_flights):
    """Nothing is hidden between the speeds: the record of the whole maneuver has no gap."""
    flight = smooth_flights[name]
    assert np.diff(flight["time"]).max() < 0.02
    speed = flight["calibrated_airspeed"] / KNOT
    assert (speed.max(), speed.min()) == (
        pytest.approx(160.0, abs=3.0),
        pytest.approx(100.0, abs=3.0),
    )
    with pytest.raises(BadInputError, match="change both"):  # a dwell belongs to a speed
        override(MANEUVERS[name].card, {"speeds_kt": [160.0, 100.0]})


def test_figure_eight_turns_as_far_to_one_side_as_to_the_other(smooth_flights):
    flight = smooth_flights["figure_eight"]
    circling = on_kind(flight, "figure_eight")
    swept = np.diff(np.unwrap(flight["heading"]))[circling[1:]]
    assert swept[swept > 0].sum() == pytest.approx(-swept[swept < 0].sum(), rel=0.02)
    assert swept[swept > 0].sum() == pytest.approx(
        2 * np.pi * sum(MANEUVERS["figure_eight"].card.turns), rel=0.02
    )


def test_power_stays_and_pitch_holds_the_airspeed():
    """One circle in smooth air by the autopilot, with the airspeed held by throttle and by pitch."""
    cards = [{"speeds_kt": [140.0], "fixed_power": power} for power in (0, 1)]
    flights = [fly(Case(maneuver="circle", turbulence="none", card=card)) for card in cards]
    circles = [np.char.startswith(flight.segment, "circle") for flight in flights]
    flight, on = flights[1], circles[1]
    power = flight["manifold_pressure_left"][on] / INCH_OF_MERCURY
    assert np.ptp(power[len(power) // 10 :]) < 0.3
    assert np.max(np.abs(flight["calibrated_airspeed"][on] / KNOT - 140.0)) < 2.0
    assert np.max(np.abs(flight["altitude"][on] - flight.case.altitude)) < 50.0 * FOOT
    throttle, pitch = (
        np.ptp(each["altitude"][on]) for each, on in zip(flights, circles, strict=True)
    )
    assert pitch > 3.0 * throttle  # the altitude wanders
    with pytest.raises(BadInputError, match="0 or 1"):
        fly(Case(maneuver="circle", card={"fixed_power": 2}))


CARD = MANEUVERS["step_decrease"].card


def test_numbers_come_in_written_units_and_are_held_in_si():
    changed = override(
        CARD, {"dwell_s": 20, "speeds_kt": [150.0, 110], "step_inhg": 2, "bank_limit_deg": 20.0}
    )
    assert changed.dwell == 20.0
    assert changed.speeds == pytest.approx((150 * KNOT, 110 * KNOT))
    assert changed.step == pytest.approx(2 * INCH_OF_MERCURY)
    assert changed.bank_limit == pytest.approx(20 * DEGREE)
    assert CARD.dwell != 20.0
    # Another unit of the same dimension is taken.
    assert override(CARD, {"dwell_ms": 5000.0}).dwell == 5.0
    assert override(CARD, {"speeds_mps": [70.0, 60.0]}).speeds == (70.0, 60.0)
    assert override(MANEUVERS["rapid_decel"].card, {"repeats": 3}).repeats == 3


@pytest.mark.parametrize("key", ["dwel_s", "dwell", "dwell_kt", "speed_kt", "heading_"])
def test_a_wrong_key_names_the_known_ones(key):
    with pytest.raises(UnknownNameError, match=r"Known: speeds_kt, turn_rate_degps.*dwell_s"):
        override(CARD, {key: 1.0})


@pytest.mark.parametrize("speeds", [160.0, [], "160", [160.0, -1.0], [100.0, 160.0], [160.0]])
def test_speeds_of_the_wrong_shape_are_refused(speeds):
    with pytest.raises(BadInputError):
        override(CARD, {"speeds_kt": speeds})


@pytest.mark.parametrize(
    ("key", "value"),
    [
        *(("dwell_s", value) for value in ([1.0], "20", True, float("nan"))),
        *(("turn_rate_degps", 0.0), ("settle_s", -1.0), ("step_inhg", 0.0)),
    ],
)
def test_a_value_of_the_wrong_kind_is_refused(key, value):
    with pytest.raises(BadInputError):
        override(CARD, {key: value})
    with pytest.raises(BadInputError, match="whole"):
        override(MANEUVERS["rapid_decel"].card, {"repeats": 1.5})


@pytest.mark.parametrize("name", MANEUVERS)
def test_every_number_of_every_card_has_a_known_suffix(name):
    override(MANEUVERS[name].card, {"speeds_kt": [150.0, 130.0, 120.0]})
