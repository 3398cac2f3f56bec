"""The table of physical effects that a case may name.

A new effect is one entry on the page of its family.
"""

from collections.abc import Iterable

from pitotbench.catalog import Catalog
from pitotbench.effects import air, airframe, pneumatic, propulsion, recorder, stability
from pitotbench.effects.effect import AircraftEffect as AircraftEffect
from pitotbench.effects.effect import AirEffect as AirEffect
from pitotbench.effects.effect import Choice as Choice
from pitotbench.effects.effect import Effect as Effect
from pitotbench.effects.effect import Excitation as Excitation
from pitotbench.effects.effect import Named, choose, forms_in_time
from pitotbench.effects.effect import Parameter as Parameter
from pitotbench.effects.effect import SensorEffect as SensorEffect
from pitotbench.effects.effect import share_of_size as share_of_size
from pitotbench.effects.formula import FORMULAS as FORMULAS
from pitotbench.effects.overlay import Baseline as Baseline
from pitotbench.effects.overlay import Overlay as Overlay
from pitotbench.effects.own_terms import own_terms, term_named
from pitotbench.effects.response import Signals as Signals

_PAGES = {
    "pneumatic": (pneumatic,),
    "das": (recorder,),
    "air": (air,),
    "airframe": (airframe, stability),
    "propulsion": (propulsion,),
}
# The effects of each family, in the order in which they stand on its pages: that of every table.
FAMILIES: dict[str, tuple[Effect, ...]] = {
    family: tuple(
        entry for page in pages for entry in vars(page).values() if isinstance(entry, Effect)
    )
    for family, pages in _PAGES.items()
}
_ALL = tuple(effect for family in FAMILIES.values() for effect in family)
EFFECTS: Catalog[Effect] = Catalog("effect", {effect.name: effect for effect in _ALL}, term_named)
# What every simulation gets wrong in several places at once: the terms of its own file.
OWN_TERMS = frozenset(
    {
        "control_effectiveness",
        "control_moments",
        "induced_drag",
        *(
            effect.name
            for effect in FAMILIES["airframe"]
            if effect.part == "lift, stability and damping"
        ),
    }
)
# The table, and every effect of it from a time on and for a time.
FORMS: Catalog[Effect] = Catalog(
    "effect",
    {form.name: form for effect in _ALL for form in (effect, *forms_in_time(effect))},
    term_named,
)


def effect_of(name: str) -> Effect:
    """Return an effect of the table in any form, or a formula, by its name.

    Raises UnknownNameError.
    """
    return FORMULAS[name] if name in FORMULAS else FORMS[name]


def additional_terms(baseline: Baseline) -> tuple[AircraftEffect, ...]:
    """Return the terms of an aircraft's own file that stand next to the effects of the table."""
    table = (e for e in EFFECTS.values() if isinstance(e, AircraftEffect))
    return tuple(own_terms(baseline, table))


def chosen(entries: Iterable[Named]) -> tuple[Choice, ...]:
    """Return the effects that a case names, with their sizes. Effects of size zero are omitted.

    Raises UnknownNameError for an unknown effect, BadInputError for impossible parameters.
    """
    return choose(entries, Catalog("effect", {**EFFECTS, **FORMULAS}, term_named))
