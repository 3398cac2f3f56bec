"""From truth to log: each piece of a sensor, each imperfection and effect in its place, and what no
log tells.
"""

import re
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyarrow import parquet
from tests.sensing import synthetic_flight as fixture

from pitotbench import (
    BadInputError,
    Case,
    Flight,
    FlightLog,
    air,
    read_case,
    read_log,
    write_case,
    write_log,
)
from pitotbench.calibration.options import COLUMNS, USUAL
from pitotbench.effects import EFFECTS
from pitotbench.logbook.columns import QUANTITIES
from pitotbench.records.case import DataSystem, EffectSpec, PressureErrorSpec, Wind
from pitotbench.sensing.recorder import (
    PLAIN,
    add_noise,
    header,
    indicated_impact_pressure,
    known_curve,
    noise_stream,
    quantize,
    record,
    resolution,
    saturate,
    slow_error,
    truth_path,
    write_truth,
)
from pitotbench.sensing.sampling import SYSTEMS, data_system
from pitotbench.units import INCH_OF_MERCURY, KNOT

CHANNEL_NAMES = [f.name for f in fields(FlightLog) if f.name not in ("header", "air_temperature")]


def test_a_perfect_system_records_the_truth():
    flight = fixture.flight(case=fixture.unbiased())
    log = record(flight, fixture.PERFECT, 1)
    for name in ("time", "static_pressure", "velocity_north", "velocity_east", "velocity_down"):
        np.testing.assert_allclose(getattr(log, name), flight[name], rtol=1e-12, err_msg=name)
    np.testing.assert_allclose(
        log.impact_pressure, flight["total_pressure"] - flight["static_pressure"], rtol=1e-9
    )
    for channel in PLAIN:
        if (
            isinstance(channel.noise, str) or channel.noise == 0.0
        ):  # a perfect system has no noise of its own
            np.testing.assert_allclose(
                getattr(log, channel.name),
                flight[channel.name],
                atol=0.51 * resolution(channel, fixture.PERFECT),
                rtol=1e-12,
                err_msg=channel.name,
            )
    np.testing.assert_array_equal(log.segment, flight.segment)
    np.testing.assert_array_equal(log.on_condition, flight.on_condition)


def test_the_known_error_sits_in_the_impact_pressure_alone():
    flight = fixture.flight()
    log = record(flight, fixture.PERFECT, 1)
    curve = known_curve(flight.case.pressure_error)
    true = flight["total_pressure"] - flight["static_pressure"]
    np.testing.assert_allclose(curve.impact_pressure(log.impact_pressure), true, rtol=1e-9)
    assert np.max(np.abs(log.impact_pressure - true)) > 5.0
    np.testing.assert_allclose(log.static_pressure, flight["static_pressure"])


@pytest.mark.parametrize("recovery", [1.0, 0.9])
def test_temperature_probe(recovery):
    flight = fixture.flight()
    log = record(flight, replace(fixture.PERFECT, recovery_factor=recovery), 1)
    q, p = flight["total_pressure"] - flight["static_pressure"], flight["static_pressure"]
    back = air.air_temperature(log.total_temperature, air.mach_from_impact_pressure(q, p), recovery)
    np.testing.assert_allclose(back, fixture.AIR_TEMPERATURE, rtol=1e-12)


@pytest.mark.parametrize("name", list(SYSTEMS))
def test_noise_is_the_systems(name):
    """The difference to the noiseless log of the same flight has the stated deviation in every
    channel.
    """
    das, flight = SYSTEMS[name], fixture.flight(seconds=400.0)
    quiet = replace(das, **dict.fromkeys(fixture.NOISE_FIELDS + fixture.RESOLUTION_FIELDS, 0.0))
    noisy, clean = record(flight, das, 3), record(flight, quiet, 3)
    deviations = {
        "impact_pressure": das.impact_pressure_noise,
        "static_pressure": das.static_pressure_noise,
        "total_temperature": das.temperature_noise,
        "velocity_north": das.velocity_noise,
        "velocity_east": das.velocity_noise,
        "roll": das.attitude_noise,
        "pitch_rate": das.rate_noise,
        "specific_force_z": das.acceleration_noise,
        "sideslip": das.vane_noise,
        "altitude": das.altitude_noise,
    }
    for channel, deviation in deviations.items():
        difference = getattr(noisy, channel) - getattr(clean, channel)
        assert difference.std() == pytest.approx(deviation, rel=0.12), channel
        assert abs(difference.mean()) < 0.2 * deviation, channel


def test_resolution_and_range():
    das = replace(SYSTEMS["50/50"], impact_pressure_range=2000.0, impact_pressure_resolution=5.0)
    log = record(fixture.flight(), das, 1)
    assert log.impact_pressure.max() == 2000.0
    np.testing.assert_allclose(np.mod(log.impact_pressure, 5.0), 0.0)


def test_velocity_is_held_between_fixes():
    log = record(fixture.flight(), data_system("20/1"), 1)
    assert log.gps_fresh.sum() == 31
    stale = ~log.gps_fresh[1:]
    assert not np.diff(log.velocity_north)[stale].any()
    assert not np.diff(log.altitude)[stale].any()
    assert np.diff(log.velocity_north)[~stale].all()
    assert np.diff(log.roll)[stale].any()
    # The vertical velocity by the system, or by wish.
    flight = fixture.flight()
    assert log.velocity_down is None
    assert record(flight, data_system("20/1"), 1, velocity_down=True).velocity_down is not None
    assert record(flight, data_system("50/50"), 1, velocity_down=False).velocity_down is None


@pytest.mark.parametrize("missing", [("roll", "elevator"), ("velocity_down",)])
def test_a_channel_that_is_left_out_moves_no_other_noise(missing):
    flight = fixture.flight()
    fewer = replace(flight, channels={k: v for k, v in flight.channels.items() if k not in missing})
    down = "velocity_down" not in missing
    whole = record(flight, data_system("50/50"), 1)
    part = record(fewer if down else flight, data_system("50/50"), 1, velocity_down=down)
    assert set(whole.channels()) == set(CHANNEL_NAMES)
    assert set(whole.channels()) - set(part.channels()) == set(missing)
    for name, values in part.channels().items():
        np.testing.assert_array_equal(values, getattr(whole, name), err_msg=name)


def test_latencies():
    flight = fixture.flight(case=fixture.unbiased())
    prompt = record(flight, fixture.PERFECT, 1)
    late = record(flight, replace(fixture.PERFECT, air_latency=0.25, gps_latency=0.4), 1)
    np.testing.assert_allclose(late.impact_pressure[25:], prompt.impact_pressure[:-25], rtol=1e-9)
    np.testing.assert_allclose(late.velocity_east[40:], prompt.velocity_east[:-40], rtol=1e-9)
    np.testing.assert_array_equal(late.roll, prompt.roll)


def test_heading_is_interpolated_through_north():
    flight = fixture.flight()
    log = record(flight, replace(fixture.PERFECT, air_rate=33.0, gps_rate=33.0), 1)
    true = np.interp(log.time, flight["time"], np.unwrap(flight["heading"]))
    error = np.angle(np.exp(1j * (log.heading - true)))
    assert np.ptp(log.heading) > 6.0
    assert np.max(np.abs(error)) < 1e-4


def test_a_gap_stays_a_gap():
    flight = fixture.flight(gap=20.0)
    log = record(flight, data_system("20/1"), 1)
    assert np.max(np.diff(log.time)) > 19.9
    error = log.velocity_north - np.interp(log.time, flight["time"], flight["velocity_north"])
    assert np.max(np.abs(error[log.gps_fresh])) < 0.6


def test_same_seed_same_log_and_another_seed_or_rate_another_draw():
    flight = fixture.flight(case=fixture.unbiased())
    one, two = record(flight, SYSTEMS["20/1"], 7), record(flight, SYSTEMS["20/1"], 7)
    for name, values in one.channels().items():
        np.testing.assert_array_equal(values, getattr(two, name), err_msg=name)
    assert one.header == two.header
    truth = record(flight, fixture.PERFECT, 1).impact_pressure

    def noise(rate: int, seed: int):
        return (
            record(flight, data_system(f"{rate}/10"), seed).impact_pressure - truth[:: 100 // rate]
        )

    first, slow = noise(50, 1), noise(25, 1)
    assert abs(np.corrcoef(first, noise(50, 2))[0, 1]) < 0.1
    assert abs(np.corrcoef(first[::2], slow)[0, 1]) < 0.12  # same instants
    assert abs(np.corrcoef(first[: len(slow)], slow)[0, 1]) < 0.12  # same place in the stream


def test_the_header_tells_the_case_and_no_truth():
    case = Case(
        wind=Wind(speed=21.7 * KNOT), effects=(EffectSpec("belly_pod", {"drag_area_m2": 0.31}),)
    )
    header = record(fixture.flight(case=case), SYSTEMS["20/1"], 9).header
    assert header["seeds"] == {"truth": 1, "sensor": 9}
    assert header["case"]["das"]["air_rate_hz"] == 20.0
    assert header["case"]["aircraft"] == "navajo"
    assert {"pitotbench", "jsbsim", "numpy"} == set(header["versions"])
    told = repr(header)
    for secret in (
        "wind",
        "pressure_error",
        "effects",
        "belly",
        "21.7",
        "0.31",
        "-0.13",
        "inverse",
    ):
        assert secret not in told, secret
    # The digest tells cases apart.
    digests = [
        record(fixture.flight(1.0, case=c), SYSTEMS["20/1"], 9).header["case_sha256"]
        for c in (case, case, Case())
    ]
    assert digests[0] == digests[1] != digests[2]


def test_a_log_of_the_bench_states_every_accuracy_that_would_else_be_the_usual_one():
    """Simulated sensors have no constant error, so that the bound of a synthetic log assumes none."""
    stated = record(fixture.flight(), fixture.PERFECT, 1).header["accuracy"]
    assert set(stated) == {f.name for f in fields(USUAL) if getattr(USUAL, f.name) > 0.0}
    assert set(stated.values()) == {0.0}
    case = Case(accuracy={"temperature_k": 1.0, "impact_pressure_zero_pa": 50.0})
    asked = header(case, fixture.PERFECT, 1)["accuracy"]
    assert asked == {**stated, "temperature_k": 1.0, "impact_pressure_zero_pa": 50.0}


def test_a_log_of_the_bench_states_every_column_that_its_sensors_do_not_need():
    """But the latencies, which a case may have: they are free where the latency is not given."""
    stated = record(fixture.flight(), fixture.PERFECT, 1).header["priors"]
    assert {*stated, "latency_s", "height_latency_s"} == {*COLUMNS}
    assert set(stated.values()) == {0.0}


def test_truth_reads_back(tmp_path):
    flight = fixture.flight(case=Case(effects=(EffectSpec("lag", {"lag_s": 0.3}),)))
    path = write_truth(flight, tmp_path / "log.csv")
    assert path == tmp_path / "log.truth.parquet" == truth_path(tmp_path / "log.csv")
    back = parquet.read_table(path)
    assert read_case(back.schema.metadata[b"pitotbench case"].decode()) == flight.case
    columns = {
        f"true_{QUANTITIES[n].column if n in QUANTITIES else n}": v
        for n, v in flight.channels.items()
    }
    assert set(back.column_names) == {*columns, "segment", "on_condition"}
    for name, values in columns.items():
        np.testing.assert_array_equal(back[name].to_numpy(), values, err_msg=name)
    np.testing.assert_array_equal(back["segment"].to_numpy(), flight.segment)
    np.testing.assert_array_equal(back["on_condition"].to_numpy(), flight.on_condition)
    with pytest.raises(BadInputError, match="the truth of a simulated flight"):
        read_log(path)
    path.unlink()
    write_log(record(fixture.flight(), SYSTEMS["20/1"], 1), tmp_path / "log.parquet")
    assert [p.name for p in tmp_path.iterdir()] == ["log.parquet"]  # and no truth


def test_an_error_of_the_static_source_moves_both_pressures_and_any_other_the_impact_pressure_alone():
    cases = {
        place: Case(pressure_error=PressureErrorSpec(location=place))
        for place in ("static", "total", "impact")
    }
    flight = fixture.flight()
    logs = {
        place: record(fixture.flight(case=case), fixture.PERFECT, 1)
        for place, case in cases.items()
    }
    static = logs.pop("static")
    assert np.max(np.abs(static.static_pressure - flight["static_pressure"])) > 5.0
    np.testing.assert_allclose(
        static.static_pressure + static.impact_pressure, flight["total_pressure"], rtol=1e-12
    )
    for log in logs.values():
        np.testing.assert_allclose(log.static_pressure, flight["static_pressure"], rtol=1e-12)
        np.testing.assert_array_equal(log.impact_pressure, static.impact_pressure)


def test_a_case_names_a_place_that_there_is():
    case = Case(pressure_error=PressureErrorSpec(location="static"))
    assert read_case(write_case(case)) == case
    with pytest.raises(BadInputError, match=r"pressure_error\.location"):
        read_case('[pressure_error]\nlocation = "pitot"\n')


def test_the_slow_height_error_has_its_level_and_its_memory_and_goes_on_while_nobody_records():
    time = np.arange(0.0, 40000.0, 2.0)
    error = slow_error(time, 2.0, 90.0, np.random.default_rng(4))
    assert np.std(error) == pytest.approx(2.0, rel=0.1)
    assert np.mean(error[45:] * error[:-45]) / np.var(error) == pytest.approx(np.exp(-1.0), abs=0.1)

    def across_pauses(seconds):
        paused = slow_error(
            time + seconds * (np.arange(len(time)) // 50), 2.0, 90.0, np.random.default_rng(4)
        )
        return np.corrcoef(paused[49:-1:50], paused[50::50])[0, 1]

    assert abs(across_pauses(10000.0)) < 0.2
    assert across_pauses(20.0) > 0.6


def test_a_receiver_without_a_slow_error_records_what_it_did_before():
    flight, das = fixture.flight(), replace(fixture.PERFECT, altitude_noise=1.5)
    log, drifting = record(flight, das, 3), record(flight, replace(das, altitude_drift=2.0), 3)
    apart = drifting.altitude - log.altitude
    assert np.max(np.abs(apart)) > 0.2
    assert np.max(np.abs(np.diff(apart))) < 0.3  # the white noise is the same draw
    np.testing.assert_array_equal(drifting.static_pressure, log.static_pressure)


DAS = DataSystem()


@given(st.lists(st.floats(-1e5, 1e5), min_size=1), st.sampled_from([0.01, 0.2, 0.3, 1.0, 1.5, 5.0]))
def test_quantize_rounds_to_the_nearest_step(values, resolution):
    rounded = quantize(np.array(values), resolution)
    assert np.all(np.abs(rounded - values) <= resolution * (0.5 + 1e-6))
    np.testing.assert_allclose(rounded / resolution, np.rint(rounded / resolution), atol=1e-6)
    np.testing.assert_array_equal(quantize(rounded, resolution), rounded)


def test_ends_steps_and_a_table_by_hand():
    assert [repr(float(v)) for v in quantize(np.array([0.12341, 1630.37]), 0.001)] == [
        "0.123",
        "1630.37",
    ]
    np.testing.assert_array_equal(
        saturate(np.array([-3.0, 5.0, 99.0]), 0.0, 10.0), [0.0, 5.0, 10.0]
    )
    spec = PressureErrorSpec("table", airspeed=(40.0, 80.0), values=(0.1, 0.1))
    assert indicated_impact_pressure(np.array([1000.0]), known_curve(spec)) == pytest.approx(900.0)


def test_noise_has_its_deviation_and_is_white():
    noise = add_noise(np.zeros(200_000), 12.0, noise_stream(1, "impact_pressure", DAS))
    assert noise.std() == pytest.approx(12.0, rel=0.01)
    assert abs(noise.mean()) < 0.1
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.01


def test_streams_are_independent_and_repeatable():
    def draw(seed=1, channel="roll", das=DAS):
        return noise_stream(seed, channel, das).standard_normal(5000)

    np.testing.assert_array_equal(draw(), draw())
    slow = DataSystem(air_rate=20.0, gps_rate=1.0)
    for other in (draw(seed=2), draw(channel="pitch"), draw(das=slow)):
        assert abs(np.corrcoef(draw(), other)[0, 1]) < 0.05


SENSORS = [name for name, effect in EFFECTS.items() if effect.acts_on == "sensors"]


def flown(*effects: EffectSpec, gap: float = 0.0) -> Flight:
    flight = fixture.flight(seconds=40.0, gap=gap, case=fixture.unbiased(effects=effects))
    speeds = {f"propeller_speed_{side}": np.full(len(flight), 270.0) for side in ("left", "right")}
    return replace(flight, channels={**flight.channels, **speeds})


def differing(one: FlightLog, other: FlightLog) -> set[str]:
    a, b = one.channels(), other.channels()
    assert set(a) == set(b)
    return {name for name in a if not np.array_equal(a[name], b[name])}


@pytest.mark.parametrize("name", SENSORS)
def test_a_log_differs_where_the_effect_says(name):
    das = data_system("50/50")
    plain = record(flown(), das, 1)
    log = record(flown(EffectSpec(name, EFFECTS[name].typical())), das, 1)
    allowed = {*EFFECTS[name].changes, *EFFECTS[name].also}
    assert differing(log, plain) <= allowed
    assert name in ("saturation", "temperature_drift") or differing(
        log, plain
    )  # these two are still in this flight


def test_an_effect_that_is_felt_is_lagged_before_the_noise():
    """The same noise on top: it cancels but for one step of rounding."""
    das = data_system("50/50")
    lagged = record(flown(EffectSpec("pitot_lag", {"lag_s": 0.5125})), das, 1)
    difference = lagged.impact_pressure - record(flown(), das, 1).impact_pressure
    smooth = np.convolve(difference, np.ones(9) / 9.0, mode="valid")
    assert np.abs(difference[4:-4] - smooth).max() < 0.5  # the noise is 12 Pa
    assert np.abs(difference).max() > 10.0
    assert not re.search(r"lag|0\.5125", str(lagged.header))  # which tells no effect


def test_the_recorders_faults_come_after_the_noise():
    das = data_system("50/50")
    stored = record(flown(EffectSpec("quantization", {"step_pa": 25.0})), das, 1)
    np.testing.assert_allclose(stored.impact_pressure % 25.0, 0.0)
    held = record(flown(EffectSpec("sample_and_hold", {"period_s": 0.2})), das, 1)
    assert np.mean(np.diff(held.impact_pressure) == 0.0) == pytest.approx(0.9, abs=0.01)


def test_latency_equals_that_of_the_data_system():
    das = data_system("50/50")
    by_effect = record(flown(EffectSpec("gps_latency", {"latency_s": 0.3}), gap=30.0), das, 1)
    by_system = record(flown(gap=30.0), replace(das, gps_latency=0.3), 1)
    for name in ("velocity_north", "velocity_east", "velocity_down", "altitude"):
        np.testing.assert_allclose(getattr(by_effect, name), getattr(by_system, name), atol=0.0102)


def test_a_gauge_reads_high_by_its_error():
    das = data_system("50/50")
    read = record(
        flown(EffectSpec("manifold_pressure_gauge", {"left_inhg": 1.0, "right_inhg": 0.0})), das, 1
    )
    plain = record(flown(), das, 1)
    np.testing.assert_allclose(
        read.manifold_pressure_left - plain.manifold_pressure_left, INCH_OF_MERCURY, atol=5.01
    )
    np.testing.assert_array_equal(read.manifold_pressure_right, plain.manifold_pressure_right)


def test_effects_on_the_aircraft_are_not_the_sensors_business_and_the_mass_is_that_of_the_weight_sheet():
    """The truth holds the load that an effect hides; the sheet, and so the log, does not."""
    das, truth = data_system("50/50"), flown()
    plain = record(truth, das, 1)
    assert (
        differing(record(flown(EffectSpec("belly_pod", {"drag_area_m2": 0.1})), das, 1), plain)
        == set()
    )
    hidden = flown(EffectSpec("mass", {"mass_kg": 150.0}))
    hidden = replace(hidden, channels={**hidden.channels, "mass": truth["mass"] + 150.0})
    assert differing(record(hidden, das, 1), plain) == set()
    assert hidden["mass"][0] == truth["mass"][0] + 150.0
