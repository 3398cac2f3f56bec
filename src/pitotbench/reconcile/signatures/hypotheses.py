"""The table of effects as hypotheses: which are fitted, which are counted, and which are forms of one cause."""

from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS, FORMS, Effect, Parameter, SensorEffect
from pitotbench.effects.part_of_flight import FROM, TO

# Effects on recorded samples (repeats, steps, ceilings) are counted in the log checks and not fitted.
COUNTED = tuple(name for name, effect in EFFECTS.items() if isinstance(effect, SensorEffect) and effect.after_noise)
# Every effect in all its forms; those for a part of the flight are looked at where the log makes them promising.
FITTED: Catalog[Effect] = Catalog(
    "effect", {name: form for name, form in FORMS.items() if (form.part_of or name) not in COUNTED}
)
WHOLE_FLIGHT: Catalog[Effect] = Catalog("effect", {n: form for n, form in FITTED.items() if not form.part_of})

# Effects that are one model with another: the drag of a gear that is out has no other term than that of a pod, and
# a share of the impact pressure is lost in the tube or in the transducer.
ONE_MODEL = {"gear_not_up": "belly_pod", "impact_pressure_scale": "total_pressure_loss"}

# Told by the level of the gusts, beside the effects that are fitted.
GUSTS = ("turbulence_level", "turbulence_scale")

VANES = {"angle_of_attack", "sideslip"}  # the channels of the flow vanes
EVENTS = ("at_s", FROM.name)  # the shapes of an effect that is an event: its time in the flight


def searched_shapes(effect: Effect) -> tuple[Parameter, ...]:
    """Return the shapes of an effect that are searched for: times, and all shapes of another form of a cause.

    Of an effect for a part of the flight only its begin and end are searched for.
    """
    if effect.part_of:
        return tuple(p for p in effect.parameters if p in (FROM, TO))
    shapes = (p for p in effect.parameters if p.shape)
    return tuple(p for p in shapes if effect.variant_of or p.name.endswith("_s"))


def cause_of(name: str) -> str:
    """Return the effect of which this one is a form, else its name.

    A second-order line and a lag have one cause.
    """
    return FITTED[name].cause


def lasts(name: str) -> bool:
    """Whether an effect acts over the whole flight, so that it is to be seen in another flight as well."""
    return not FITTED[name].part_of


def happens_once(name: str) -> bool:
    """Whether an effect is an event, with a time at which it happens."""
    return any(p.shape and p.name.endswith("_s") for p in FITTED[name].parameters)


def returns(name: str) -> bool:
    """Whether an effect is to be seen in another flight of the airplane: it lasts, and is no event at a time."""
    return lasts(name) and not any(p.shape and p.name in EVENTS for p in FITTED[name].parameters)


def reads_gusts(name: str) -> bool:
    """Whether an effect is one of the flow vanes alone."""
    effect = FITTED[name]
    return isinstance(effect, SensorEffect) and set(effect.changes) <= VANES
