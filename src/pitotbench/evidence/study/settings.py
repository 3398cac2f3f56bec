"""The flights of the study: the paper's five maneuvers in several airs, by several pilots, with several cards."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial

from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.evidence.study.looks import COVERING, PAPER, Look
from pitotbench.pressure_error import PAPER_MODELS
from pitotbench.records.case import Case, EffectSpec, Wind
from pitotbench.sense import SYSTEMS
from pitotbench.simulate.maneuvers import PAPER_MANEUVERS
from pitotbench.units import KNOT

SPECIFICATION = 0.1  # times the injected noise gives that of the instrument's specification
BOTH_WAYS = "step_both_ways"  # Step Decrease with every speed on both headings
STEEPER = (4.0, 8.0, 12.0, 16.0, 24.0)
STEEP = 12.0  # times the vertical speed: the one at which data rates are compared
ALIKE = 0.5  # times the noise of a receiver alone gives that of an integrated solution
FIXED_POWER = "fixed power"  # the variant of Circle that the paper's pilot flew
ERROR_SIZES = (0.25, 0.5, 2.0)  # times the default pressure error, which was chosen with C5 in view
ERROR_SHAPES = ("linear truth", "quadratic truth", "knee truth")


@dataclass(frozen=True, slots=True)
class StudySetting:
    """The air and the pilot. `rare` settings only explain a result and are flown for a fifth of the seeds."""

    turbulence: str
    pilot: str
    what: str
    rare: bool = False
    effects: tuple[EffectSpec, ...] = ()
    flown: tuple[str, ...] = PAPER_MANEUVERS
    wind: float | None = None  # kt, the wind of the case unless given


# The airplane differed from the simulator (Martos et al. 2011, II.B, III.A): it had a pod under the belly, and its
# turns needed more power. The sizes are the typical ones of the effects table. An effect not in it is omitted.
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
    """One flight of the study and the looks at it; `variant` is the name of an unusual card."""

    setting: str
    case: Case
    looks: tuple[Look, ...]
    variant: str = "standard"
    track: bool = False
    curves: bool = False


def case_of(setting: str, maneuver: str, seed: int, **changes: object) -> Case:
    """Return the case of a setting, maneuver and seed, with other changes."""
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
    """An unusual card: its maneuver, and the changed numbers."""

    name: str
    maneuver: str
    card: dict[str, object] = field(default_factory=dict)


VARIANTS = (
    Variant("six speeds", "four_leg", {"speeds_kt": (160.0, 148.0, 136.0, 124.0, 112.0, 100.0)}),
    Variant("long steps", "step_decrease", {"step_time_s": 20.0}),
)


FLOWN_BY_PITCH = (
    "smooth",
    "light",
    "autopilot",
    "busy",
)  # the settings of Circle at fixed power; the last two rare


def main_looks() -> tuple[Look, ...]:
    """Return the looks of every claim: data systems, models, V_down, turns, and the covering bound."""
    looks = []
    for das in SYSTEMS:
        for down in (True, False):
            looks += [Look(das, replace(PAPER, use_down=down, on_condition=on)) for on in (False, True)]
        looks += [Look(das, replace(PAPER, model=model)) for model in PAPER_MODELS[1:]]
        looks += [Look(das, COVERING)]
    looks += [Look("20/1", options, gps_noise=ALIKE) for options in (PAPER, COVERING)]
    return tuple(looks)


def pooled_looks() -> tuple[Look, ...]:
    """Return the fits of ground velocity as two and as three outputs, with noise on the impact pressure alone.

    All data at each data system, and on-condition data at 50/50 Hz.
    """
    pooled = partial(Look, given_down=True, alone=True, form="vector")
    options = [replace(PAPER, use_down=down) for down in (True, False)]
    every = [pooled(das, one) for das in SYSTEMS for one in options]
    return (*every, *(pooled("50/50", replace(one, on_condition=True)) for one in options))


def other_errors() -> tuple[Look, ...]:
    """Return the fits of every model to pressure errors that were not chosen for a claim."""
    models = [replace(PAPER, model=model) for model in PAPER_MODELS]
    sizes = [Look("50/50", one, "error size", times) for times in ERROR_SIZES for one in models]
    return (*sizes, *(Look("50/50", one, shape) for shape in ERROR_SHAPES for one in models))


def explaining_looks() -> tuple[Look, ...]:
    """Return the looks that explain C2, C5, C7 and C8.

    They have less noise, steeper paths with and without V_down, ground velocity as outputs, and other errors.
    """
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
    vector = [Look("50/50", replace(PAPER, use_down=down), form="vector") for down in (True, False)]
    return (*quiet, *steep, *slow, *vector, *quiet_looks(), *pooled_looks(), *other_errors(), STRAIGHT)


STRAIGHT = Look("20/1", replace(PAPER, model="quadratic", on_condition=True))  # like the airplane's data


def quiet_looks() -> tuple[Look, ...]:
    """Return the looks with and without V_down, with the specified noise of pressure and velocity."""
    return tuple(
        Look("50/50", replace(PAPER, use_down=down), noise=SPECIFICATION, gps_noise=SPECIFICATION)
        for down in (True, False)
    )


def rare_looks() -> tuple[Look, ...]:
    """Return the looks of a rare setting."""
    held = tuple(Look(das, replace(PAPER, use_down=down)) for das in SYSTEMS for down in (True, False))
    return (*held, STRAIGHT, Look("50/50", COVERING))


def airplane_looks() -> tuple[Look, ...]:
    """Return looks with the airplane's data system and model, with and without turns, by both methods."""
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
    """Return the flights of a seed that the claims need, with `rare` also those of rare settings."""
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
    for name in FLOWN_BY_PITCH if rare else FLOWN_BY_PITCH[:2]:
        yield Sortie(name, case_of(name, "circle", seed, card={"fixed_power": 1}), plain, FIXED_POWER)
    for variant in VARIANTS:
        yield Sortie("smooth", case_of("smooth", variant.maneuver, seed, card=variant.card), plain, variant.name)
