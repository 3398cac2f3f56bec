"""Effects of the engines and propellers: power, speed, and what the throttle and the gauges tell."""

from collections.abc import Mapping

from pitotbench.effects.effect import POWER, AircraftEffect, Parameter, SensorEffect
from pitotbench.effects.overlay import (
    Baseline,
    BodyForce,
    Overlay,
    PropertySetting,
    difference,
    product,
    quotient,
    size,
    total,
)
from pitotbench.effects.response import Signals
from pitotbench.records import BadInputError
from pitotbench.units import INCH_OF_MERCURY

# Find the left and the right engine of a twin, and check that an aircraft has the properties of an effect.


def left_and_right(effect: str, baseline: Baseline) -> tuple[int, int]:
    """Return JSBSim's numbers of the left and the right engine. Raises BadInputError unless there are two."""
    if len(baseline.engines) != 2:
        raise BadInputError(f"effect {effect!r} needs a twin; {baseline.aircraft!r} has {len(baseline.engines)}")
    # The second coordinate of a structural location is positive to the right.
    left, right = sorted(range(2), key=lambda i: baseline.engines[i].location[1])
    return left, right


def require_declared(effect: str, baseline: Baseline, *paths: str) -> None:
    """Raise BadInputError where an aircraft lacks properties that an effect sets."""
    missing = [path for path in paths if path not in baseline.declared]
    if missing:
        raise BadInputError(
            f"effect {effect!r} sets {', '.join(missing)}, which {baseline.aircraft!r} does not have; leave it out"
        )


# Engines that lose a constant power at any setting: friction, or a driven accessory.

FRICTION_LOSS_NAME = "friction_loss"

KILOWATT = 1000.0 / 745.699872  # hp


def _build_friction_loss(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    settings = tuple(
        PropertySetting(
            f"propulsion/engine[{i}]/friction-hp",
            total(baseline.engines[i].friction, product(KILOWATT, size(FRICTION_LOSS_NAME, key))),
        )
        for i, key in zip(left_and_right(FRICTION_LOSS_NAME, baseline), ("left_kw", "right_kw"), strict=True)
    )
    return Overlay(
        sizes=tuple((size(FRICTION_LOSS_NAME, key), value) for key, value in sizes.items()), settings=settings
    )


FRICTION_LOSS = AircraftEffect(
    name=FRICTION_LOSS_NAME,
    family="propulsion",
    acts_on="aircraft",
    parameters=(
        Parameter("left_kw", 8.0, -20.0, 80.0, "power that the left engine loses"),
        Parameter("right_kw", 4.0, -20.0, 80.0, "power that the right engine loses"),
    ),
    source="Heywood 1988, Internal Combustion Engine Fundamentals, ch. 13: friction and accessories",
    what="An engine loses a constant power.",
    shows_in=POWER,  # a constant power is a larger share of a low one
    variant_of="power_deficit",
    build=_build_friction_loss,
)


# Governors set to another propeller speed.

GOVERNOR_SPEED_NAME = "governor_speed"

_OFFSET = size(GOVERNOR_SPEED_NAME, "offset_rpm")

GOVERNOR = "powerplant/governor-rpm"


def _build_governor_speed(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    require_declared(GOVERNOR_SPEED_NAME, baseline, GOVERNOR)
    setting = PropertySetting(GOVERNOR, total(baseline.declared[GOVERNOR], _OFFSET))
    return Overlay(sizes=((_OFFSET, sizes["offset_rpm"]),), settings=(setting,))


GOVERNOR_SPEED = AircraftEffect(
    name=GOVERNOR_SPEED_NAME,
    family="propulsion",
    acts_on="aircraft",
    parameters=(Parameter("offset_rpm", -75.0, -500.0, 100.0, "propeller speed above that of the model"),),
    source="governor stops are set to some 25 rpm; a pilot's lever to 50 rpm (estimate)",
    what="The propellers turn faster or slower than in the model.",
    shows_in=POWER,  # the governor holds its speed at high power only
    build=_build_governor_speed,
)


# Manifold-pressure gauges that read wrong. The power stays: only the recorded pressure changes.

MANIFOLD_PRESSURE_GAUGE_CHANNELS = ("manifold_pressure_left", "manifold_pressure_right")


def _offset(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    errors = (sizes["left_inhg"], sizes["right_inhg"])
    read = {
        name: signals[name] + e * INCH_OF_MERCURY
        for name, e in zip(MANIFOLD_PRESSURE_GAUGE_CHANNELS, errors, strict=True)
    }
    return signals.with_channels(**read)


def _scale(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    errors = (sizes["left"], sizes["right"])
    return signals.with_channels(
        **{
            name: (1.0 + e) * signals[name]
            for name, e in zip(MANIFOLD_PRESSURE_GAUGE_CHANNELS, errors, strict=True)
        }
    )


MANIFOLD_PRESSURE_GAUGE = SensorEffect(
    name="manifold_pressure_gauge",
    family="propulsion",
    acts_on="sensors",
    parameters=(
        Parameter("left_inhg", 0.6, -4.0, 4.0, "left gauge reads too high"),
        Parameter("right_inhg", -0.4, -4.0, 4.0, "right gauge reads too high"),
    ),
    source="aircraft gauges are read to some 0.2 inHg and err by as much again (estimate)",
    what="The recorded manifold pressure is not that of the engine.",
    shows_in=POWER,
    changes=MANIFOLD_PRESSURE_GAUGE_CHANNELS,
    function=_offset,
)

MANIFOLD_PRESSURE_SCALE = SensorEffect(
    name="manifold_pressure_scale",
    family="propulsion",
    acts_on="sensors",
    parameters=(
        Parameter("left", 0.02, -0.2, 0.2, "left gauge reads too high by this share"),
        Parameter("right", -0.015, -0.2, 0.2, "right gauge reads too high by this share"),
    ),
    source="standard of manifold-pressure instruments: SAE AS8042, 1985; 2 % is 0.6 inHg at 30 inHg (estimate)",
    what="The scale of the manifold-pressure gauges is wrong.",
    shows_in=POWER,
    variant_of="manifold_pressure_gauge",
    changes=MANIFOLD_PRESSURE_GAUGE_CHANNELS,
    function=_scale,
)


# Engines that give less power for the fuel they burn.

POWER_DEFICIT_NAME = "power_deficit"


def _build_power_deficit(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    settings = []
    for engine, key in zip(
        left_and_right(POWER_DEFICIT_NAME, baseline), ("left_fraction", "right_fraction"), strict=True
    ):
        fuel = baseline.engines[engine].fuel_per_power
        if fuel <= 0.0:
            raise BadInputError(
                f"effect {POWER_DEFICIT_NAME!r} needs piston engines that state their bsfc; leave it out"
            )
        # JSBSim's power is fuel flow over bsfc: a larger bsfc takes power away and leaves the fuel flow.
        path = f"propulsion/engine[{engine}]/bsfc-lbs_hphr"
        settings.append(PropertySetting(path, quotient(fuel, difference(1.0, size(POWER_DEFICIT_NAME, key)))))
    return Overlay(
        sizes=tuple((size(POWER_DEFICIT_NAME, key), value) for key, value in sizes.items()),
        settings=tuple(settings),
    )


POWER_DEFICIT = AircraftEffect(
    name=POWER_DEFICIT_NAME,
    family="propulsion",
    acts_on="aircraft",
    parameters=(
        Parameter("left_fraction", 0.06, -0.3, 0.5, "share of the left engine's indicated power that is missing"),
        Parameter("right_fraction", 0.03, -0.3, 0.5, "the same for the right engine"),
    ),
    source="Heywood 1988, Internal Combustion Engine Fundamentals: indicated power less friction; wear of 5 %",
    what="An engine gives less power than its manifold pressure and speed indicate.",
    shows_in=POWER,
    build=_build_power_deficit,
)


# Propellers that give less thrust for their power: damaged, or of another type than in the model.

PROPELLER_EFFICIENCY_NAME = "propeller_efficiency"


def _build_propeller_efficiency(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    forces = [
        BodyForce(
            product(size(PROPELLER_EFFICIENCY_NAME, key), f"propulsion/engine[{i}]/thrust-lbs"),
            baseline.engines[i].location,
        )
        for i, key in zip(
            left_and_right(PROPELLER_EFFICIENCY_NAME, baseline), ("left_change", "right_change"), strict=True
        )
    ]
    return Overlay(
        sizes=tuple((size(PROPELLER_EFFICIENCY_NAME, key), value) for key, value in sizes.items()),
        forces=tuple(forces),
    )


PROPELLER_EFFICIENCY = AircraftEffect(
    name=PROPELLER_EFFICIENCY_NAME,
    family="propulsion",
    acts_on="aircraft",
    parameters=(
        Parameter("left_change", -0.04, -0.4, 0.2, "relative change of the left propeller's thrust"),
        Parameter("right_change", -0.04, -0.4, 0.2, "the same for the right propeller"),
    ),
    source="McCormick 1995: installed efficiency errs by some 5 %; the change is a force at the propeller",
    what="A propeller gives less thrust than in the model for the same power.",
    shows_in=POWER,
    build=_build_propeller_efficiency,
)


# Throttle pickups that are not linear: right at both ends of the travel, wrong between them.

THROTTLE_PICKUP_CHANNELS = ("throttle_left", "throttle_right")


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    bends = (sizes["left"], sizes["right"])
    read = {
        name: signals[name] + 4.0 * bend * signals[name] * (1.0 - signals[name])
        for name, bend in zip(THROTTLE_PICKUP_CHANNELS, bends, strict=True)
    }
    return signals.with_channels(**read)


THROTTLE_PICKUP = SensorEffect(
    name="throttle_pickup",
    family="propulsion",
    acts_on="sensors",
    parameters=(
        Parameter("left", 0.03, -0.2, 0.2, "left throttle reads too far open at half travel, share of the travel"),
        Parameter("right", -0.02, -0.2, 0.2, "the same of the right throttle"),
    ),
    source="our form, a parabola; Doebelin 1990, Measurement Systems: a load on a potentiometer bends its reading "
    "between the ends",
    what="The throttle pickups bend: the recorded throttles err between idle and full.",
    shows_in=POWER,
    changes=THROTTLE_PICKUP_CHANNELS,
    function=_apply,
)


# Throttles that differ while their levers stand together.

THROTTLE_RIGGING_NAME = "throttle_rigging"

_PATHS = {"left": "ap/throttle-bias-left-norm", "right": "ap/throttle-bias-right-norm"}


def _build_throttle_rigging(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    require_declared(THROTTLE_RIGGING_NAME, baseline, *_PATHS.values())
    # Times one: an expression must be XML, and the bare path of a property is not.
    settings = tuple(
        PropertySetting(path, product(size(THROTTLE_RIGGING_NAME, side), 1.0)) for side, path in _PATHS.items()
    )
    return Overlay(
        sizes=tuple((size(THROTTLE_RIGGING_NAME, key), value) for key, value in sizes.items()), settings=settings
    )


THROTTLE_RIGGING = AircraftEffect(
    name=THROTTLE_RIGGING_NAME,
    family="propulsion",
    acts_on="aircraft",
    parameters=(
        Parameter("left", 0.02, -0.2, 0.2, "left throttle more open, share of the plate's travel"),
        Parameter("right", -0.02, -0.2, 0.2, "right throttle more open"),
    ),
    source="cable rigging: lever stagger of some 2 % of travel (estimate)",
    what="The engines give different power with the levers together.",
    shows_in=POWER,
    build=_build_throttle_rigging,
)
