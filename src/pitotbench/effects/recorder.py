"""Effects of the data system: clocks, GPS receiver, compass, inertial unit, probe and vanes."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

import numpy as np

from pitotbench import air
from pitotbench.axes import body_to_earth
from pitotbench.channels import numbers_from
from pitotbench.effects.effect import (
    CHANGING_AIRSPEED,
    RANGE_OF_AIRSPEED,
    SIDESLIP,
    TEMPERATURE,
    TURNING,
    Parameter,
    SensorEffect,
    SensorFunction,
    Sizes,
    elapsed,
    reads,
)
from pitotbench.effects.response import Signals, delayed, first_order, play
from pitotbench.units import DEGREE, Array

# The channels that a fault of the air-data bus changes together, and those of GPS velocity and of
# attitude.
PRESSURES = ("impact_pressure", "static_pressure")
AIR_DATA = (*PRESSURES, "total_temperature")
VELOCITIES = ("velocity_north", "velocity_east", "velocity_down")
ATTITUDE = ("roll", "pitch", "heading")
RATES = ("roll_rate", "pitch_rate", "yaw_rate")


def _late(
    names: tuple[str, ...], latency: Callable[[Signals, Sizes], Array | float]
) -> SensorFunction:
    """The function of channels that are recorded late by a `latency` [s], which may change in time.

    Channels that the log lacks are passed over.
    """
    return lambda signals, sizes: signals.with_channels(
        **{
            name: delayed(signals, signals[name], latency(signals, sizes))
            for name in names
            if name in signals
        }
    )


AIR_DATA_LATENCY = SensorEffect(
    name="air_data_latency",
    part="pitot line",
    parameters=(
        Parameter("latency_s", 0.3, 0.01, 3.0, "time by which pressures and temperature are late"),
    ),
    source="Martos, Kiszely and Foster 2011, §II.C: time alignment of air data and GPS",
    what="Pressures and temperature are recorded late against GPS and attitude.",
    shows_in=CHANGING_AIRSPEED,
    changes=PRESSURES,
    also=("total_temperature",),
    function=_late(AIR_DATA, lambda signals, sizes: sizes["latency_s"]),
)


def _apply_antenna_lever_arm(signals: Signals, sizes: Sizes) -> Signals:
    roll, pitch, heading, p, q, r = (signals[name] for name in (*ATTITUDE, *RATES))
    x, y, z = sizes["forward_m"], sizes["right_m"], sizes["down_m"]
    # ω × r in body axes; the log's velocity is in earth axes.
    swing = np.stack([q * z - r * y, r * x - p * z, p * y - q * x])
    added = body_to_earth(swing, roll, pitch, heading)
    changed = {
        name: signals[name] + part
        for name, part in zip(VELOCITIES, added, strict=True)
        if name in signals
    }
    if "altitude" in signals:
        arm = np.repeat(np.array([[x], [y], [z]]), len(signals), axis=1)
        changed["altitude"] = signals["altitude"] - body_to_earth(arm, roll, pitch, heading)[2]
    return signals.with_channels(**changed)


ANTENNA_LEVER_ARM = SensorEffect(
    name="antenna_lever_arm",
    part="GPS receiver and its clock",
    parameters=(
        Parameter("forward_m", -3.0, -15.0, 15.0, "antenna ahead of the center of gravity"),
        Parameter("right_m", 1.0, -15.0, 15.0, "antenna right of it"),
        Parameter("down_m", -1.0, -5.0, 5.0, "antenna below it"),
    ),
    source="rigid-body kinematics, v = v_cg + ω × r (Stevens and Lewis 2003, Aircraft Control and "
    "Simulation)",
    what="GPS velocity and altitude are those of the antenna, which moves around the center of "
    "gravity.",
    shows_in=TURNING,
    for_whole_flight=True,
    changes=("velocity_north", "velocity_east"),
    also=("velocity_down", "altitude"),
    needs=(*ATTITUDE, *RATES),
    function=_apply_antenna_lever_arm,
)


CLOCK_DRIFT = SensorEffect(
    name="clock_drift",
    part="GPS receiver and its clock",
    parameters=(
        Parameter(
            "drift_ppm", 500.0, -5000.0, 5000.0, "GPS data late, a millionth of the time flown"
        ),
    ),
    source="quartz clocks: 20 to 100 ppm by data sheet, some 1,000 ppm for a loaded computer's "
    "timer",
    what="The clocks of air data and GPS drift apart during the flight.",
    shows_in=CHANGING_AIRSPEED,
    for_whole_flight=True,
    changes=("velocity_north", "velocity_east"),
    also=("velocity_down", "altitude"),
    function=_late(
        numbers_from("gps"), lambda signals, sizes: 1e-6 * sizes["drift_ppm"] * elapsed(signals)
    ),
)


COMPASS_SOURCE = (
    "Handbook of Magnetic Compass Adjustment 2004 (NGA, formerly Pub. 226), ch. 5: B sin ψ + C cos "
    "ψ + D sin 2ψ + E cos 2ψ; "
)


def _waves(times: int) -> SensorFunction:
    """Return the deviation with so many waves in a full turn."""

    def read(heading: Array, sizes: Sizes) -> Array:
        deviation = sizes["sine_deg"] * np.sin(times * heading) + sizes["cosine_deg"] * np.cos(
            times * heading
        )
        return heading + DEGREE * deviation

    return reads("heading", read)


COMPASS_DEVIATION = SensorEffect(
    name="compass_deviation",
    part="attitude and inertial unit",
    parameters=(
        Parameter("sine_deg", 1.5, -20.0, 20.0, "heading too large on east: coefficient B"),
        Parameter("cosine_deg", -1.0, -20.0, 20.0, "heading too large on north: coefficient C"),
    ),
    source=COMPASS_SOURCE + "14 CFR 25.1327: at most 10° once compensated",
    what="Magnetized parts of the airplane turn the compass: the heading has a semicircular "
    "deviation.",
    shows_in=TURNING,
    for_whole_flight=True,
    changes=("heading",),
    function=_waves(1),
)

QUADRANTAL_DEVIATION = SensorEffect(
    name="quadrantal_deviation",
    part="attitude and inertial unit",
    parameters=(
        Parameter("sine_deg", 1.0, -10.0, 10.0, "heading too large on northeast: coefficient D"),
        Parameter(
            "cosine_deg", -0.5, -10.0, 10.0, "heading too large on north and south: coefficient E"
        ),
    ),
    source=COMPASS_SOURCE + "D and E come from induced magnetism",
    what="Soft iron in the airplane bends the earth's field: the heading has a quadrantal "
    "deviation.",
    shows_in=TURNING,
    for_whole_flight=True,
    changes=("heading",),
    function=_waves(2),
)


def _apply_dropped_samples(signals: Signals, sizes: Sizes) -> Signals:
    # Bursts begin at random, so often that the share of lost rows comes out right. The first row of
    # a stretch is never lost: the recorder has no earlier value to repeat.
    draw = np.random.default_rng(int(sizes["seed"]))
    start, lost = sizes["fraction"] / sizes["burst_rows"], np.zeros(len(signals), dtype=np.bool_)
    begun = np.flatnonzero(draw.random(len(signals)) < start)
    for length in range(int(sizes["burst_rows"])):
        lost[np.minimum(begun + length, len(signals) - 1)] = True
    lost[[part.start for part in signals.stretches()]] = False
    source = np.maximum.accumulate(np.where(lost, 0, np.arange(len(signals))))
    return signals.with_channels(
        **{name: signals[name][source] for name in AIR_DATA if name in signals}
    )


DROPPED_SAMPLES = SensorEffect(
    name="dropped_samples",
    part="recorder",
    parameters=(
        Parameter("fraction", 0.05, 0.001, 0.5, "share of the rows that is lost"),
        Parameter("burst_rows", 4.0, 1.0, 200.0, "rows lost at once", shape=True),
        Parameter("seed", 1.0, 0.0, 1e6, "which rows are lost", shape=True),
    ),
    source="Gilbert 1960, Bell System Technical Journal 39: losses come in bursts",
    what="Some rows of air data are lost; the recorder repeats the last good one.",
    shows_in=CHANGING_AIRSPEED,  # a row that repeats shows only while the pressure changes
    changes=PRESSURES,
    also=("total_temperature",),
    after_noise=True,
    function=_apply_dropped_samples,
)


GPS_LATENCY = SensorEffect(
    name="gps_latency",
    part="GPS receiver and its clock",
    parameters=(
        Parameter("latency_s", 0.3, 0.01, 3.0, "time by which GPS velocity and altitude are late"),
    ),
    source="Martos, Kiszely and Foster 2011, §II.C: time alignment of air data and GPS",
    what="GPS velocity and altitude are recorded late against the air data.",
    shows_in=CHANGING_AIRSPEED,
    changes=("velocity_north", "velocity_east"),
    also=("velocity_down", "altitude"),
    function=_late(numbers_from("gps"), lambda signals, sizes: sizes["latency_s"]),
)


GPS_SMOOTHING = SensorEffect(
    name="gps_smoothing",
    part="GPS receiver and its clock",
    parameters=(Parameter("lag_s", 0.3, 0.01, 3.0, "time constant of the receiver's filter"),),
    source="receivers' low-dynamics navigation filters; first-order form (estimate)",
    what="The receiver smooths its velocity and so delays it.",
    shows_in=CHANGING_AIRSPEED,
    variant_of="gps_latency",
    changes=VELOCITIES[:2],
    also=VELOCITIES[2:],
    function=lambda signals, sizes: signals.with_channels(
        **{
            name: first_order(signals, signals[name], sizes["lag_s"])
            for name in VELOCITIES
            if name in signals
        }
    ),
)


GPS_VELOCITY_SCALE = SensorEffect(
    name="gps_velocity_scale",
    part="GPS receiver and its clock",
    parameters=(
        Parameter("north", 0.01, -0.2, 0.2, "velocity toward north too large by this share"),
        Parameter("east", 0.01, -0.2, 0.2, "velocity toward east too large by this share"),
    ),
    source="Snyder 1987, Map Projections, USGS PP 1395: scale factors of projections, and the "
    "length of a degree of longitude, which a latitude that is wrong by 1° at 40° changes by 1.5 %",
    what="The horizontal velocity of the GPS has a wrong scale.",
    shows_in=RANGE_OF_AIRSPEED,
    for_whole_flight=True,
    changes=("velocity_north", "velocity_east"),
    function=lambda signals, sizes: signals.with_channels(
        velocity_north=(1.0 + sizes["north"]) * signals["velocity_north"],
        velocity_east=(1.0 + sizes["east"]) * signals["velocity_east"],
    ),
)


FORCES = ("specific_force_x", "specific_force_y", "specific_force_z")


def _apply_inertial_unit_misalignment(signals: Signals, sizes: Sizes) -> Signals:
    angles = (DEGREE * sizes[name] for name in ("roll_deg", "pitch_deg", "yaw_deg"))
    axes = body_to_earth(
        np.eye(3), *(np.full(3, angle) for angle in angles)
    ).T  # of the unit, in the airplane's
    roll, pitch, heading = (signals[name] for name in ATTITUDE)
    forward, right, down = (
        body_to_earth(np.repeat(axis[:, None], len(signals), axis=1), roll, pitch, heading)
        for axis in axes
    )
    turned = np.arctan2(forward[1], forward[0]) - heading
    changed = {
        "roll": np.arctan2(right[2], down[2]),
        "pitch": -np.arcsin(np.clip(forward[2], -1.0, 1.0)),
        # The heading keeps its count of full turns.
        "heading": heading + np.mod(turned + np.pi, 2.0 * np.pi) - np.pi,
    }
    for names in (RATES, FORCES):
        if all(name in signals for name in names):
            changed |= dict(
                zip(names, axes @ np.stack([signals[name] for name in names]), strict=True)
            )
    return signals.with_channels(**changed)


INERTIAL_UNIT_MISALIGNMENT = SensorEffect(
    name="inertial_unit_misalignment",
    part="attitude and inertial unit",
    parameters=(
        Parameter("roll_deg", 1.0, -15.0, 15.0, "unit mounted right wing down"),
        Parameter("pitch_deg", 1.0, -15.0, 15.0, "unit mounted nose up"),
        Parameter("yaw_deg", 1.0, -15.0, 15.0, "unit mounted nose right"),
    ),
    source="rotation of axes (Stevens and Lewis 2003, Aircraft Control and Simulation, §1.3); "
    "1° is a mount that was leveled by eye (estimate)",
    what="The inertial unit is not aligned with the airplane.",
    shows_in=TURNING,
    for_whole_flight=True,
    changes=ATTITUDE,
    also=(*RATES, *FORCES),
    function=_apply_inertial_unit_misalignment,
)


INERTIAL_SOURCE = (
    "Klein and Morelli 2006, Aircraft System Identification, ch. 10: data compatibility, with a "
    "scale and a bias of each gyro and accelerometer; "
)


GYROS = dict(zip(("roll", "pitch", "yaw"), RATES, strict=True))
ACCELEROMETERS = dict(zip(("forward", "right", "down"), FORCES, strict=True))


def _scale_and_zero(sensors: Mapping[str, str], zero: str, unit: float) -> SensorFunction:
    """The function of sensors by their axes, each with a scale and a zero in `unit` [SI]."""

    def function(signals: Signals, sizes: Sizes) -> Signals:
        return signals.with_channels(
            **{
                name: (1.0 + sizes[f"{axis}_scale"]) * signals[name] + unit * sizes[axis + zero]
                for axis, name in sensors.items()
            }
        )

    return function


def _of_each_axis(axes: Iterable[str], zero: Parameter, what: str) -> tuple[Parameter, ...]:
    """A scale and a zero of the sensor of each axis, any of which may be off alone."""
    scale = Parameter("_scale", 0.1, -0.5, 1.0, "too large by this share", may_be_missing=True)
    return tuple(
        replace(each, name=axis + each.name, what=f"{what.format(axis)}: {each.what}")
        for axis in axes
        for each in (scale, zero)
    )


GYRO_CALIBRATION = SensorEffect(
    name="gyro_calibration",
    part="attitude and inertial unit",
    parameters=_of_each_axis(
        GYROS,
        Parameter("_zero_degps", 1.0, -20.0, 20.0, "reading at rest", may_be_missing=True),
        "{} rate",
    ),
    source=INERTIAL_SOURCE + "wrong ranges and units of gyros, 1 °/s is an uncalibrated chip "
    "(estimate)",
    what="A gyro has a wrong scale or zero: its rate disagrees with the change of the attitude.",
    shows_in=TURNING,
    by_size=True,
    for_whole_flight=True,
    changes=RATES,
    function=_scale_and_zero(GYROS, "_zero_degps", DEGREE),
)

ACCELEROMETER_CALIBRATION = SensorEffect(
    name="accelerometer_calibration",
    part="attitude and inertial unit",
    parameters=_of_each_axis(
        ACCELEROMETERS,
        Parameter("_zero_g", 0.05, -0.5, 0.5, "reading in free fall", may_be_missing=True),
        "specific force {}",
    ),
    source=INERTIAL_SOURCE + "0.05 g is an uncalibrated chip (estimate)",
    what="An accelerometer has a wrong scale or zero: it disagrees with the change of the ground "
    "velocity.",
    shows_in=TURNING,
    by_size=True,
    for_whole_flight=True,
    changes=FORCES,
    function=_scale_and_zero(ACCELEROMETERS, "_zero_g", air.GRAVITY),
)


QUANTIZATION = SensorEffect(
    name="quantization",
    part="impact transducer",
    parameters=(Parameter("step_pa", 40.0, 1.0, 500.0, "step of both pressures"),),
    source="Widrow and Kollár 2008, Quantization Noise: a step q adds q²/12; 34 Pa is 12 bits "
    "over 138 kPa",
    what="The pressures are stored in coarse steps.",
    shows_in=CHANGING_AIRSPEED,  # a pressure that changes crosses many steps
    changes=PRESSURES,
    after_noise=True,
    function=lambda signals, sizes: signals.with_channels(
        **{name: np.rint(signals[name] / sizes["step_pa"]) * sizes["step_pa"] for name in PRESSURES}
    ),
)


_ROUNDING = 1e-6  # periods: a row this close to a refresh has it


def _apply_sample_and_hold(signals: Signals, sizes: Sizes) -> Signals:
    source = np.arange(len(signals))
    for part in signals.stretches():
        time = signals.time[part]
        frame = np.floor((time - time[0]) / sizes["period_s"] + _ROUNDING)
        source[part] = part.start + np.searchsorted(frame, frame)  # the first row of each frame
    return signals.with_channels(
        **{name: signals[name][source] for name in AIR_DATA if name in signals}
    )


SAMPLE_AND_HOLD = SensorEffect(
    name="sample_and_hold",
    part="recorder",
    parameters=(Parameter("period_s", 0.25, 0.02, 5.0, "time between new values"),),
    source="Martos, Kiszely and Foster 2011, §II.C: data systems of several rates on one time base",
    what="Air data refresh more slowly than they are recorded: each value repeats.",
    shows_in=CHANGING_AIRSPEED,  # a value that repeats shows only while the pressure changes
    changes=PRESSURES,
    also=("total_temperature",),
    after_noise=True,
    function=_apply_sample_and_hold,
)


SATURATION = SensorEffect(
    name="saturation",
    part="recorder",
    parameters=(
        Parameter("ceiling_pa", 3500.0, 500.0, 20000.0, "greatest impact pressure; 0 for none"),
    ),
    source="range of the transducer or of its amplifier; 3,500 Pa is 146 KIAS",
    what="Above some airspeed the impact pressure does not rise any more.",
    shows_in=RANGE_OF_AIRSPEED,  # only the highest airspeeds reach the ceiling
    changes=("impact_pressure",),
    after_noise=True,  # an amplifier at its limit gives a constant, not noise around it
    function=reads(
        "impact_pressure", lambda pressure, sizes: np.minimum(pressure, sizes["ceiling_pa"])
    ),
)


PROBE_SOURCE = (
    "Trenkle and Reinhardt 1973, AGARDograph 160 vol. 2: recovery 0.6 to 0.99; probe errors of "
    "some kelvin"
)


def _recovery(signals: Signals, sizes: Sizes) -> Signals:
    # Noise can make the impact pressure slightly negative at rest, where the Mach number is zero.
    mach = air.mach_from_impact_pressure(
        signals["impact_pressure"].clip(min=0.0), signals["static_pressure"]
    )
    static = air.air_temperature(signals["total_temperature"], mach)
    return signals.with_channels(
        total_temperature=air.total_temperature(static, mach, 1.0 - sizes["deficit"])
    )


RECOVERY_DEFICIT = SensorEffect(
    name="recovery_deficit",
    part="thermometer, or the day",
    parameters=(
        Parameter(
            "deficit", 0.2, -0.2, 1.0, "one minus the recovery factor, against full recovery"
        ),
    ),
    source=PROBE_SOURCE,
    what="The temperature probe measures only part of the ram rise.",
    shows_in=TEMPERATURE,
    changes=("total_temperature",),
    needs=PRESSURES,
    function=_recovery,
)

TEMPERATURE_BIAS = SensorEffect(
    name="temperature_bias",
    part="thermometer, or the day",
    parameters=(Parameter("bias_k", 2.5, -15.0, 15.0, "reading above the probe's temperature"),),
    source=PROBE_SOURCE,
    what="The temperature probe reads too warm or too cold by a constant.",
    shows_in=TEMPERATURE,
    changes=("total_temperature",),
    function=reads("total_temperature", lambda temperature, sizes: temperature + sizes["bias_k"]),
)


VANE_SOURCE = (
    "Gracey 1958, NACA TN 4351: the flow at a vane is that of the airplane with its upwash; "
    "Haering 1995, NASA TM-104316: scale and offset of flow angles are calibrated in flight"
)


def _vane(angle: Array, sizes: Sizes) -> Array:
    return (1.0 + sizes["scale"]) * angle + DEGREE * sizes["offset_deg"]


ALPHA_VANE_CALIBRATION = SensorEffect(
    name="alpha_vane_calibration",
    part="flow vanes",
    parameters=(
        Parameter("scale", 0.1, -0.5, 1.0, "reading too large by this share of the angle: upwash"),
        Parameter("offset_deg", 1.0, -10.0, 10.0, "reading at zero angle of attack"),
    ),
    source=VANE_SOURCE,
    what="The vane of the angle of attack has a wrong scale or zero.",
    shows_in=RANGE_OF_AIRSPEED,
    for_whole_flight=True,
    changes=("angle_of_attack",),
    function=reads("angle_of_attack", _vane),
)

SIDESLIP_VANE_CALIBRATION = SensorEffect(
    name="sideslip_vane_calibration",
    part="flow vanes",
    parameters=(
        Parameter(
            "scale", 0.1, -0.5, 1.0, "reading too large by this share of the angle: sidewash"
        ),
        Parameter("offset_deg", 1.0, -10.0, 10.0, "reading at zero sideslip"),
    ),
    source=VANE_SOURCE,
    what="The vane of the sideslip has a wrong scale or zero.",
    shows_in=SIDESLIP,
    for_whole_flight=True,
    changes=("sideslip",),
    function=reads("sideslip", _vane),
)


VANE_FRICTION = SensorEffect(
    name="vane_friction",
    part="flow vanes",
    parameters=(
        Parameter(
            "alpha_deg",
            0.5,
            0.02,
            10.0,
            "angle of attack that turns the vane back after a turn-round",
        ),
        Parameter("sideslip_deg", 0.5, 0.02, 10.0, "the same of the sideslip vane"),
    ),
    source="Gracey 1958, NACA TN 4351: vanes and their friction; the play operator of "
    "Krasnosel'skii and Pokrovskii 1989",
    what="The flow vanes stick: dirt, ice or a dry bearing.",
    shows_in=SIDESLIP,
    changes=("angle_of_attack", "sideslip"),
    function=lambda signals, sizes: signals.with_channels(
        angle_of_attack=play(signals["angle_of_attack"], DEGREE * sizes["alpha_deg"]),
        sideslip=play(signals["sideslip"], DEGREE * sizes["sideslip_deg"]),
    ),
)
