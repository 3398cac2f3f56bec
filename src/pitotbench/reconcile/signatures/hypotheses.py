"""The table of effects as hypotheses: which are fitted, which are counted, and which are forms of one cause."""

from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS, Effect, Parameter, SensorEffect

# Effects on recorded samples (repeats, steps, ceilings) are counted in the log checks and not fitted.
COUNTED = tuple(name for name, effect in EFFECTS.items() if isinstance(effect, SensorEffect) and effect.after_noise)
FITTED: Catalog[Effect] = Catalog(
    "effect", {name: effect for name, effect in EFFECTS.items() if name not in COUNTED}
)

# Effects that are one model with another: the drag of a gear that is out has no other term than that of a pod.
ONE_MODEL = {"gear_not_up": "belly_pod"}


def searched_shapes(effect: Effect) -> tuple[Parameter, ...]:
    """Return the shapes of an effect that are searched for: times, and all shapes of another form of a cause."""
    shapes = (p for p in effect.parameters if p.shape)
    return tuple(p for p in shapes if effect.variant_of or p.name.endswith("_s"))


def cause_of(name: str) -> str:
    """Return the effect of which this one is a form, else its name.

    A second-order line and a lag have one cause.
    """
    return FITTED[name].cause


def happens_once(name: str) -> bool:
    """Whether an effect is an event, with a time at which it happens."""
    return any(p.shape and p.name.endswith("_s") for p in FITTED[name].parameters)
