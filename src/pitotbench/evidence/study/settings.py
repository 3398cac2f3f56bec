"""What is flown: the paper's five maneuvers in several airs, by several pilots, and variants of their cards."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.evidence.study.looks import COVERING, PAPER, Look
from pitotbench.pressure_error import PAPER_MODELS
from pitotbench.records.case import Case, EffectSpec, Wind
from pitotbench.sense import SYSTEMS
from pitotbench.simulate.maneuvers import PAPER_MANEUVERS
from pitotbench.units import KNOT

SPECIFICATION = 0.1  # of the injected noise: that of the instrument's specification
BOTH_WAYS = "step_both_ways"  # Step Decrease with every speed on both headings
STEEPER = (4.0, 8.0, 12.0, 16.0, 24.0)
STEEP = 12.0  # times the vertical speed: where data rates are compared
ALIKE = 0.5  # of the noise of a receiver alone: that of an integrated solution


@dataclass(frozen=True, slots=True)
class StudySetting:
    """Air and pilot. `rare` settings explain and are flown for a fifth of the seeds only."""

    turbulence: str
    pilot: str
    what: str
    rare: bool = False
    effects: tuple[EffectSpec, ...] = ()
    flown: tuple[str, ...] = PAPER_MANEUVERS
    wind: float | None = None  # kt, of the case unless given


# What the airplane had and the simulator had not (Martos et al. 2011, II.B, III.A): a pod under the belly, and
# turns that asked for more power. Typical sizes of the effects table; an effect that it lacks is left out.
_AIRPLANE = (
    EffectSpec("belly_pod", {"drag_area_m2": 0.1}),
    EffectSpec("turn_drag", {"coefficient_at_30deg": 0.005}),
)
AIRPLANE_EFFECTS = tuple(effect for effect in _AIRPLANE if effect.name in EFFECTS)
AIRPLANE_FLOWN = ("step_decrease", "race_track", "four_leg", "rapid_decel")

SETTINGS: Catalog[StudySetting] = Catalog(
    "setting",
    {
        "smooth": StudySetting("none", "good", "smooth air, constant wind, a good pilot: as the paper's simulator"),
        "light": StudySetting("light", "good", "light turbulence, a good pilot"),
        "autopilot": StudySetting("none", "none", "smooth air, no wind, the autopilot alone", rare=True, wind=0.0),
        "busy": StudySetting("none", "busy", "smooth air, a busy pilot", rare=True),
        "airplane": StudySetting(
            "light",
            "good",
            "light turbulence, a good pilot, the airplane's effects",
            rare=True,
            effects=AIRPLANE_EFFECTS,
            flown=AIRPLANE_FLOWN,
        ),
        "moderate": StudySetting("moderate", "good", "moderate turbulence, a good pilot", rare=True),
    },
)


@dataclass(frozen=True, slots=True)
class Sortie:
    """One flight of the study and the looks at it; `variant` names what is unusual on its card."""

    setting: str
    case: Case
    looks: tuple[Look, ...]
    variant: str = "standard"
    track: bool = False
    curves: bool = False


def case_of(setting: str, maneuver: str, seed: int, **changes: object) -> Case:
    """The case of a setting, maneuver and seed, with other changes."""
    air = SETTINGS[setting]
    case = Case(
        maneuver=maneuver,
        turbulence=air.turbulence,
        pilot=air.pilot,
        effects=air.effects,
        truth_seed=seed,
        sensor_seed=seed,
    )
    if air.wind is not None:
        case = replace(case, wind=Wind(speed=air.wind * KNOT))
    return replace(case, **changes)  # type: ignore[arg-type]


@dataclass(frozen=True, slots=True)
class Variant:
    """An unusual card: whose, and which numbers."""

    name: str
    maneuver: str
    card: dict[str, object] = field(default_factory=dict)


VARIANTS = (
    Variant("six speeds", "four_leg", {"speeds_kt": (160.0, 148.0, 136.0, 124.0, 112.0, 100.0)}),
    Variant("long steps", "step_decrease", {"step_time_s": 20.0}),
)


def main_looks() -> tuple[Look, ...]:
    """The looks of every claim: data systems, models, with and without V_down and turns, and the true bound."""
    looks = []
    for das in SYSTEMS:
        for down in (True, False):
            looks += [Look(das, replace(PAPER, use_down=down, on_condition=on)) for on in (False, True)]
        looks += [Look(das, replace(PAPER, model=model)) for model in PAPER_MODELS[1:]]
        looks += [Look(das, COVERING)]
    looks += [Look("20/1", options, gps_noise=ALIKE) for options in (PAPER, COVERING)]
    return tuple(looks)


def explaining_looks() -> tuple[Look, ...]:
    """Less noise, and steeper paths with and without V_down: what C2 and C7 are explained by."""
    quiet = [Look(das, PAPER, noise=SPECIFICATION) for das in SYSTEMS]
    steep = [
        Look("50/50", replace(PAPER, use_down=down), "vertical speed", times)
        for times in STEEPER
        for down in (True, False)
    ]
    slow = [
        Look("20/1", replace(PAPER, use_down=down), "vertical speed", STEEP, given_down=True)
        for down in (True, False)
    ]
    vector = [Look("50/50", replace(PAPER, form="vector", use_down=down)) for down in (True, False)]
    return (*quiet, *steep, *slow, *vector, *quiet_looks(), STRAIGHT)


STRAIGHT = Look("20/1", replace(PAPER, model="quadratic", on_condition=True))  # as the airplane's data were reduced


def quiet_looks() -> tuple[Look, ...]:
    """With and without V_down, the pressure and the velocity as quiet as specified."""
    return tuple(
        Look("50/50", replace(PAPER, use_down=down), noise=SPECIFICATION, gps_noise=SPECIFICATION)
        for down in (True, False)
    )


def rare_looks() -> tuple[Look, ...]:
    """What a rare setting is looked at for."""
    held = tuple(Look(das, replace(PAPER, use_down=down)) for das in SYSTEMS for down in (True, False))
    return (*held, STRAIGHT, Look("50/50", COVERING))


def airplane_looks() -> tuple[Look, ...]:
    """The airplane's data system and model, with and without turns, by the paper's method and the covering one."""
    options = [replace(method, model="quadratic") for method in (PAPER, COVERING)]
    return tuple(Look("20/1", replace(one, on_condition=straight)) for one in options for straight in (True, False))


def _looks(name: str, rare: bool) -> tuple[Look, ...]:
    if name == "airplane":
        return airplane_looks()
    if SETTINGS[name].rare:
        return (*rare_looks(), *(quiet_looks() if name == "busy" else ()))
    more = {"smooth": explaining_looks() if rare else (), "light": (STRAIGHT,)}
    return (*main_looks(), *more.get(name, ()))


def claim_sorties(seed: int, rare: bool) -> Iterator[Sortie]:
    """The flights of a seed that the claims need; with the rare ones where asked for."""
    for name, setting in SETTINGS.items():
        if setting.rare and not rare:
            continue
        for maneuver in setting.flown:
            track, curves = (seed == 1 and name == shown for shown in ("autopilot", "airplane"))
            yield Sortie(name, case_of(name, maneuver, seed), _looks(name, rare), track=track, curves=curves)
    plain = (*(Look(das) for das in SYSTEMS), Look("50/50", COVERING))
    if rare:
        models = tuple(Look("50/50", replace(PAPER, model=model)) for model in PAPER_MODELS)
        for name in ("smooth", "light"):
            yield Sortie(name, case_of(name, BOTH_WAYS, seed), (*models, Look("50/50", COVERING)))
    for variant in VARIANTS:
        yield Sortie("smooth", case_of("smooth", variant.maneuver, seed, card=variant.card), plain, variant.name)
