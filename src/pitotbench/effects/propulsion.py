"""Effects of engines and propellers: power, speed, and what the throttle and the gauges show."""

from collections.abc import Callable

from pitotbench.effects.effect import (
    POWER,
    AircraftEffect,
    Parameter,
    SensorEffect,
    SensorFunction,
    Sizes,
)
from pitotbench.effects.overlay import (
    Baseline,
    BodyForce,
    Overlay,
    PropertySetting,
    difference,
    product,
    quotient,
    total,
)
from pitotbench.records import BadInputError
from pitotbench.units import INCH_OF_MERCURY, Array


def left_and_right(effect: str, baseline: Baseline) -> tuple[int, int]:
    """Return JSBSim's numbers of the left and the right engine.

    Raises BadInputError unless there are two.
    """
    if len(baseline.engines) != 2:
        raise BadInputError(
            f"effect {effect!r} needs a twin; {baseline.aircraft!r} has {len(baseline.engines)}"
        )
    # The second coordinate of a structural location is positive to the right.
    left, right = sorted(range(2), key=lambda i: baseline.engines[i].location[1])
    return left, right


def _of_engines(effect: AircraftEffect, baseline: Baseline) -> list[tuple[int, str]]:
    """The numbers of the left and the right engine, each with the path of its size."""
    return list(zip(left_and_right(effect.name, baseline), effect.paths(), strict=True))


def require_declared(effect: str, baseline: Baseline, *paths: str) -> None:
    """Raise BadInputError where an aircraft lacks properties that an effect sets."""
    if missing := [path for path in paths if path not in baseline.declared]:
        raise BadInputError(
            f"effect {effect!r} sets {', '.join(missing)}, which {baseline.aircraft!r} does not "
            "have; leave it out"
        )


KILOWATT = 1000.0 / 745.699872  # hp

FRICTION_LOSS = AircraftEffect(
    name="friction_loss",
    part="engine or propeller, a side",
    parameters=(
        Parameter("left_kw", 8.0, -20.0, 80.0, "power that the left engine loses"),
        Parameter("right_kw", 4.0, -20.0, 80.0, "power that the right engine loses"),
    ),
    source="Heywood 1988, Internal Combustion Engine Fundamentals, ch. 13: friction and "
    "accessories",
    what="An engine loses a constant power.",
    shows_in=POWER,  # a constant power is a larger share of a low one
    variant_of="power_deficit",
    build=lambda effect, sizes, baseline: Overlay(
        sizes=effect.properties(sizes),
        settings=tuple(
            PropertySetting(
                f"propulsion/engine[{i}]/friction-hp",
                total(baseline.engines[i].friction, product(KILOWATT, path)),
            )
            for i, path in _of_engines(effect, baseline)
        ),
    ),
)


GOVERNOR = "powerplant/governor-rpm"


def _governor(effect: AircraftEffect, sizes: Sizes, baseline: Baseline) -> Overlay:
    require_declared(effect.name, baseline, GOVERNOR)
    setting = PropertySetting(GOVERNOR, total(baseline.declared[GOVERNOR], *effect.paths()))
    return Overlay(sizes=effect.properties(sizes), settings=(setting,))


GOVERNOR_SPEED = AircraftEffect(
    name="governor_speed",
    part="engine or propeller, a side",
    parameters=(
        Parameter("offset_rpm", -75.0, -500.0, 100.0, "propeller speed above that of the model"),
    ),
    source="governor stops are set to some 25 rpm; a pilot's lever to 50 rpm (estimate)",
    what="The propellers turn faster or slower than in the model.",
    shows_in=POWER,  # the governor holds its speed at high power only
    build=_governor,
)


GAUGES = ("manifold_pressure_left", "manifold_pressure_right")


def both_read(gauge: str, suffix: str, read: Callable[[Array, float], Array]) -> SensorFunction:
    """Return the function of a left and a right gauge, with sizes of this suffix.

    `read` turns true values, (n,), and a size into what the gauge shows.
    """
    return lambda signals, sizes: signals.with_channels(
        **{
            f"{gauge}_{side}": read(signals[f"{gauge}_{side}"], sizes[f"{side}{suffix}"])
            for side in ("left", "right")
        }
    )


MANIFOLD_PRESSURE_GAUGE = SensorEffect(
    name="manifold_pressure_gauge",
    part="engine instruments",
    parameters=(
        Parameter("left_inhg", 0.6, -4.0, 4.0, "left gauge reads too high"),
        Parameter("right_inhg", -0.4, -4.0, 4.0, "right gauge reads too high"),
    ),
    source="aircraft gauges are read to some 0.2 inHg and err by as much again (estimate)",
    what="The recorded manifold pressure is not that of the engine.",
    shows_in=POWER,
    changes=GAUGES,
    function=both_read(
        "manifold_pressure", "_inhg", lambda pressure, error: pressure + error * INCH_OF_MERCURY
    ),
)

MANIFOLD_PRESSURE_SCALE = SensorEffect(
    name="manifold_pressure_scale",
    part="engine instruments",
    parameters=(
        Parameter("left", 0.02, -0.2, 0.2, "left gauge reads too high by this share"),
        Parameter("right", -0.015, -0.2, 0.2, "right gauge reads too high by this share"),
    ),
    source="standard of manifold-pressure instruments: SAE AS8042, 1985; 2 % is 0.6 inHg at 30 "
    "inHg (estimate)",
    what="The scale of the manifold-pressure gauges is wrong.",
    shows_in=POWER,
    variant_of="manifold_pressure_gauge",
    for_whole_flight=True,
    changes=GAUGES,
    function=both_read("manifold_pressure", "", lambda pressure, error: (1.0 + error) * pressure),
)


def _deficit(effect: AircraftEffect, sizes: Sizes, baseline: Baseline) -> Overlay:
    settings = []
    for engine, missing in _of_engines(effect, baseline):
        fuel = baseline.engines[engine].fuel_per_power
        if fuel <= 0.0:
            raise BadInputError(
                "effect 'power_deficit' needs piston engines that state their bsfc; leave it out"
            )
        # JSBSim's power is fuel flow over bsfc: a larger bsfc takes power away and leaves the fuel
        # flow.
        path = f"propulsion/engine[{engine}]/bsfc-lbs_hphr"
        settings.append(PropertySetting(path, quotient(fuel, difference(1.0, missing))))
    return Overlay(sizes=effect.properties(sizes), settings=tuple(settings))


POWER_DEFICIT = AircraftEffect(
    name="power_deficit",
    part="engine or propeller, a side",
    parameters=(
        Parameter(
            "left_fraction",
            0.06,
            -0.3,
            0.5,
            "share of the left engine's indicated power that is missing",
        ),
        Parameter("right_fraction", 0.03, -0.3, 0.5, "the same for the right engine"),
    ),
    source="Heywood 1988, Internal Combustion Engine Fundamentals: indicated power less friction; "
    "wear of 5 %",
    what="An engine gives less power than its manifold pressure and speed indicate.",
    shows_in=POWER,
    build=_deficit,
)


PROPELLER_EFFICIENCY = AircraftEffect(
    name="propeller_efficiency",
    part="engine or propeller, a side",
    parameters=(
        Parameter(
            "left_change", -0.04, -0.4, 0.2, "relative change of the left propeller's thrust"
        ),
        Parameter("right_change", -0.04, -0.4, 0.2, "the same for the right propeller"),
    ),
    source="McCormick 1995: installed efficiency errs by some 5 %; the change is a force at the "
    "propeller",
    what="A propeller gives less thrust than in the model for the same power.",
    shows_in=POWER,
    build=lambda effect, sizes, baseline: Overlay(
        sizes=effect.properties(sizes),
        forces=tuple(
            BodyForce(
                product(path, f"propulsion/engine[{i}]/thrust-lbs"), baseline.engines[i].location
            )
            for i, path in _of_engines(effect, baseline)
        ),
    ),
)


THROTTLE_PICKUP = SensorEffect(
    name="throttle_pickup",
    part="engine instruments",
    parameters=(
        Parameter(
            "left",
            0.03,
            -0.2,
            0.2,
            "left throttle reads too far open at half travel, share of the travel",
        ),
        Parameter("right", -0.02, -0.2, 0.2, "the same of the right throttle"),
    ),
    source="our form, a parabola; Doebelin 1990, Measurement Systems: a load on a potentiometer "
    "bends its reading between the ends",
    what="The throttle pickups bend: the recorded throttles err between idle and full.",
    shows_in=POWER,
    for_whole_flight=True,
    changes=("throttle_left", "throttle_right"),
    function=both_read(
        "throttle", "", lambda travel, bend: travel + 4.0 * bend * travel * (1.0 - travel)
    ),
)


BIASES = ("ap/throttle-bias-left-norm", "ap/throttle-bias-right-norm")


def _rigging(effect: AircraftEffect, sizes: Sizes, baseline: Baseline) -> Overlay:
    require_declared(effect.name, baseline, *BIASES)
    # Times one: an expression must be XML, and the bare path of a property is not.
    pairs = zip(BIASES, effect.paths(), strict=True)
    settings = tuple(PropertySetting(bias, product(path, 1.0)) for bias, path in pairs)
    return Overlay(sizes=effect.properties(sizes), settings=settings)


THROTTLE_RIGGING = AircraftEffect(
    name="throttle_rigging",
    part="engine instruments",
    parameters=(
        Parameter("left", 0.02, -0.2, 0.2, "left throttle more open, share of the plate's travel"),
        Parameter("right", -0.02, -0.2, 0.2, "right throttle more open"),
    ),
    source="cable rigging: lever stagger of some 2 % of travel (estimate)",
    what="The engines give different power with the levers together.",
    shows_in=POWER,
    for_whole_flight=True,
    build=_rigging,
)
