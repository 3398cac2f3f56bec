"""The generator of the blind test: logs under neutral names, and the truth in a sealed file
elsewhere.

`blind signatures` comes first: it measures the strength of every effect in every setting.
"""

from argparse import ArgumentParser
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator

from pitotbench.effects import EFFECTS, FORMS
from pitotbench.effects.effect import Effect, SensorEffect
from pitotbench.records.case import Case, EffectSpec, PressureErrorSpec, Wind
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import header
from pitotbench.units import KNOT, Array
from pitotlab.blind.flown import SETTINGS, Environment, Setting, flown, has_wind, recorded
from pitotlab.blind.forms import OWN_FORMS
from pitotlab.blind.outsiders import HIDDEN_EFFECTS, OUTSIDERS, Part
from pitotlab.blind.signatures import GUSTS, PLACE, SettingSignatures, read, typical
from pitotlab.experiment import OUT
from pitotlab.sealing import FURTHER, HELD, seal, write_logs

BANDS = {"above 7": (8.0, 500.0), "4 to 7": (4.3, 6.7), "2 to 4": (2.2, 3.8)}
WEAK = ("4 to 7", "2 to 4")
USUAL_FACTORS = (0.5, 1.6)  # of typical sizes
JITTER = (0.75, 1.25)  # of each size of an effect with several
FORM_SHARE, WORLD_SHARE, PART_SHARE = 0.3, 0.3, 0.2
WEAKEST, STRONGEST, LEAST_STRONG = 0.6, 500.0, 8.0
PARTIAL = (  # effects that may act in a part of the flight only
    "alpha_static_error", "belly_pod", "impact_zero_offset", "induced_drag", "line_leak", "manifold_pressure_gauge",
    "pitot_lag", "power_deficit", "propeller_efficiency", "propwash_error", "recovery_deficit",
    "static_source_change", "static_zero_offset", "temperature_bias", "total_pressure_loss", "trim_offset",
    "turn_drag", "water_in_line",
)  # fmt: skip
INVISIBLE = ("nonstandard_temperature",)  # a gap only where the header tells the day
COUNTED = {  # sizes of what is counted or shows in the spread only
    "dropped_samples": {"fraction": (0.02, 0.12)},
    "quantization": {"step_pa": (30.0, 80.0)},
    "sample_and_hold": {"period_s": (0.2, 0.6)},
    "saturation": {"ceiling_pa": (3400.0, 4000.0)},
    "turbulence_level": {"change": (0.5, 1.5)},
}


@dataclass(frozen=True, slots=True)
class HiddenEffect:
    """An effect with its sizes, its strength (SNR) in each flight of the case, and the part of the
    flight [s] in which it acts; None for all of it."""

    name: str
    sizes: Mapping[str, float]
    strengths: tuple[float, ...]
    part: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class HiddenCase:
    """The truth of one case: one to three flights, of a band, none, two, outside or counted."""

    kind: str
    settings: tuple[str, ...]
    effects: tuple[HiddenEffect, ...]
    environment: Environment

    @property
    def formed(self) -> bool:
        """Whether form, part, gusts, step or receiver are the generator's own."""
        own = any(e.name in HIDDEN_EFFECTS or e.part is not None for e in self.effects)
        return own or not self.environment.usual


def hidden_case(
    draw: Generator, kind: str, settings: tuple[str, ...], measured: Mapping[str, SettingSignatures]
) -> HiddenCase:
    """Draw what a case hides. `measured` holds the signatures of each setting."""
    effects: list[HiddenEffect] = []
    if kind == "counted":
        effects = [_counted(draw, settings)]
    elif kind != "none":
        for _ in range(2 if kind == "two" else 1):
            taken = [cause_of(effect.name) for effect in effects]
            effects.append(_effect(draw, kind, settings, measured, taken))
    environment = _environment(draw, settings, [e.name for e in effects])
    return HiddenCase(kind, settings, tuple(effects), environment)


def cause_of(name: str) -> str:
    """The cause of an effect of the table or of the generator; an outsider is its own."""
    return _table()[name].cause


def _table() -> dict[str, Effect]:
    return {**FORMS, **HIDDEN_EFFECTS}


def _by(draw: Generator, share: float) -> bool:
    return bool(draw.random() < share)


def _environment(draw: Generator, settings: Sequence[str], names: Sequence[str]) -> Environment:
    """Draw a world of the case's own in one respect or two, or the usual one."""
    if not _by(draw, WORLD_SHARE):
        return Environment()
    flown = [SETTINGS[letter].flown for letter in settings]
    fast = max(case.das.air_rate for case in flown) > 60.0
    gusty = any(case.turbulence != "none" for case in flown) and not has_wind(names)
    respects = [r for r in ("rate", "gusts", "receiver", "probes") if r != "gusts" or gusty]
    chosen = draw.choice(respects, size=int(draw.integers(1, 3)), replace=False)
    return Environment(
        rate=float(240.0 if fast else draw.choice([60.0, 240.0])) if "rate" in chosen else 100.0,
        own_gusts="gusts" in chosen,
        receiver="receiver" in chosen,
        probes="probes" in chosen,
    )


def _counted(draw: Generator, settings: Sequence[str]) -> HiddenEffect:
    calm = any(SETTINGS[letter].flown.turbulence == "none" for letter in settings)
    name = str(draw.choice([n for n in COUNTED if not (calm and n == "turbulence_level")]))
    drawn = {key: float(draw.uniform(*limits)) for key, limits in COUNTED[name].items()}
    return HiddenEffect(name, EFFECTS[name].typical() | drawn, tuple(0.0 for _ in settings))


def _effect(
    draw: Generator,
    kind: str,
    settings: tuple[str, ...],
    measured: Mapping[str, SettingSignatures],
    taken: Sequence[str],
) -> HiddenEffect:
    """An effect whose plausible sizes reach the strength of the kind in these settings."""
    while True:
        name = str(draw.choice(_pool(draw, kind)))
        if cause_of(name) in taken or any(name not in measured[x].names for x in settings):
            continue
        part = _part(draw, name, measured[settings[0]]) if len(settings) == 1 else None
        typicals = [_strength(measured[letter], name, part) for letter in settings]
        whole = float(np.sqrt(np.sum(np.square(typicals))))
        if whole < WEAKEST:
            continue
        factor = _factor(draw, kind, whole)
        if not _within(name, factor):
            continue
        sign = -1.0 if _by(draw, 0.5) and _within(name, -factor) else 1.0
        # A weak effect keeps the ratio of its sizes, so that its strength is the one asked for.
        varied = kind not in WEAK
        sizes = _sizes(draw, name, sign * factor, measured[settings[0]], varied)
        return HiddenEffect(name, sizes, tuple(round(factor * t, 2) for t in typicals), part)


def _pool(draw: Generator, kind: str) -> list[str]:
    if kind == "outside":
        return list(OUTSIDERS)
    if _by(draw, FORM_SHARE):
        return list(OWN_FORMS)
    after = [n for n, e in EFFECTS.items() if isinstance(e, SensorEffect) and e.after_noise]
    never = {*GUSTS, *INVISIBLE, *after, *HIDDEN_EFFECTS}
    return [name for name in EFFECTS if name not in never]


def _factor(draw: Generator, kind: str, whole: float) -> float:
    """The factor on typical sizes, in bounds of strength where no band is asked for."""
    if kind in WEAK:
        low, high = BANDS[kind]
        return float(np.exp(draw.uniform(np.log(low), np.log(high)))) / whole
    factor = float(np.exp(draw.uniform(*np.log(USUAL_FACTORS))))
    if factor * whole < LEAST_STRONG:
        return float(draw.uniform(LEAST_STRONG, 2.5 * LEAST_STRONG)) / whole
    return min(factor, float(draw.uniform(0.3, 1.0)) * STRONGEST / whole)


def _part(draw: Generator, name: str, signatures: SettingSignatures) -> tuple[float, float] | None:
    if name not in PARTIAL or not _by(draw, PART_SHARE):
        return None
    last = float(signatures.time[-1])
    begin = draw.uniform(0.1, 0.45) * last
    return round(begin, 1), round(begin + draw.uniform(0.3, 0.5) * last, 1)


def _strength(signatures: SettingSignatures, name: str, part: tuple[float, float] | None) -> float:
    """Strength at typical sizes, in a part of the flight by the share of its instants."""
    row = signatures.names.index(name)
    whole = float(signatures.strengths[row])
    if part is None or whole <= 0.0:
        return whole
    unit = signatures.unit[row]
    share = np.sum(Part(*part)(signatures.time) * unit) / max(1e-12, np.sum(unit))
    return whole * float(np.sqrt(share))


def _sizes(
    draw: Generator, name: str, factor: float, signatures: SettingSignatures, varied: bool
) -> dict[str, float]:
    effect = _table()[name]
    shapes = {p.name for p in effect.parameters if p.shape}
    several = varied and len(effect.parameters) - len(shapes) > 1
    sizes = {}
    for key, value in typical(effect).items():
        drawn = value if key in shapes else factor * value
        if several and key not in shapes:
            own = effect.parameter(key)
            drawn = float(np.clip(drawn * draw.uniform(*JITTER), own.low, own.high))
        sizes[key] = drawn
    last = float(signatures.time[-1])
    for key in ("at_s", "from_s"):
        if key in sizes:
            sizes[key] = float(draw.uniform(0.2, 0.6)) * last
    return sizes


def _within(name: str, factor: float) -> bool:
    """Whether all sizes, scaled, lie in their plausible ranges."""
    sizes = (p for p in _table()[name].parameters if not p.shape)
    return all(p.low <= factor * p.typical <= p.high for p in sizes)


NOT_TOLD = ("temperature_offset_k", "pilot", "fuel", "ballast_kg")
APART = 1000  # between the seeds of the flights of a case; a set has fewer cases
HELD_NUMBER = 4  # of the flight held out


@dataclass(frozen=True, slots=True)
class SeededCase:
    """A case of a set with its seed, and whether a flight of it is held out."""

    seed: int
    case: HiddenCase
    held: bool

    def flights(self) -> Iterator[tuple[str, FlightLog]]:
        """Fly the case: the end of the name and the log of each flight, the first one last."""
        numbered = [*zip(("", *FURTHER), self.case.settings, strict=False)]
        ends = {end: (number, letter) for number, (end, letter) in enumerate(numbered)}
        if self.held:
            ends[HELD] = (HELD_NUMBER, self.case.settings[-1])
        for end, (number, letter) in reversed(ends.items()):
            seed = self.seed + APART * number
            yield end, log_of(self.case, SETTINGS[letter], seed, bend_of(self.seed))


def seeded(seed: int, cases: Sequence[HiddenCase], held: Sequence[bool]) -> dict[str, SeededCase]:
    """Return the cases of a set by name."""
    each = enumerate(zip(cases, held, strict=True))
    return {f"log-{i:04d}": SeededCase(seed + i, case, out) for i, (case, out) in each}


def told_of(cases: Mapping[str, SeededCase]) -> list[dict[str, Any]]:
    """Return the truth of cases, as it is sealed."""
    return [
        {"name": name, "seed": each.seed, "held_out": each.held, "formed": each.case.formed}
        | asdict(each.case)
        for name, each in cases.items()
    ]


def bend_of(seed: int) -> Array:
    """The parameters of the error curve of a case, (3,), the same in all its flights."""
    factor = np.random.default_rng([seed, 1]).uniform(0.5, 1.5)
    return np.array(PressureErrorSpec().parameters) * factor


def log_of(case: HiddenCase, setting: Setting, seed: int, bend: Array) -> FlightLog:
    """Fly and record one flight of a case; its header tells what the setting's header tells."""
    draw = np.random.default_rng([seed, 3])
    schedules = {e.name: Part(*e.part) for e in case.effects if e.part is not None}
    flight = flown(_case(draw, case, setting, seed, bend), case.environment, schedules)
    log = recorded(flight, case.environment, schedules)
    return replace(log, header=told_header(setting))


def told_header(setting: Setting) -> Mapping[str, Any]:
    """The header of a log of a setting: its card, nothing of the day, the pilot or the loading."""
    every = header(setting.told, setting.told.das, 0)
    case = {key: value for key, value in every["case"].items() if key not in NOT_TOLD}
    return {"format": every["format"], "case": case}


def _case(draw: Generator, case: HiddenCase, setting: Setting, seed: int, bend: Array) -> Case:
    effects = tuple(EffectSpec(e.name, e.sizes) for e in case.effects)
    wind = Wind(float(draw.uniform(2.0, 25.0)) * KNOT, float(draw.uniform(0.0, 2.0 * np.pi)))
    curve = PressureErrorSpec(parameters=tuple(float(v) for v in bend))
    return replace(
        setting.flown,
        effects=effects,
        wind=wind,
        pressure_error=curve,
        truth_seed=seed,
        sensor_seed=seed,
    )


KINDS = {
    "above 7": 150,
    "4 to 7": 75,
    "2 to 4": 40,
    "two": 50,
    "none": 65,
    "outside": 70,
    "counted": 20,
}
SMALL = {"above 7": 60, "two": 60, "none": 40, "outside": 40}
SMALL_SETTINGS = "ABCEKMNO"  # of each maneuver and each data system, calm, light
DEVELOPMENT_SEEDS, SCORED = (30_000, 40_000), 900_000
SEVERAL = {2: 0.12, 3: 0.08}  # share of the cases of so many flights
HELD_OUT = 60  # cases with a flight held out


def draw_set(
    draw: Generator,
    kinds: Mapping[str, int],
    letters: Sequence[str],
    measured: Mapping[str, SettingSignatures],
    held_out: int = HELD_OUT,
) -> tuple[list[HiddenCase], list[bool]]:
    """Return the cases of a set in random order, and whether each has a flight held out."""
    wanted = [kind for kind, number in kinds.items() for _ in range(number)]
    wanted = [wanted[i] for i in draw.permutation(len(wanted))]
    firsts = [letters[i % len(letters)] for i in draw.permutation(len(wanted))]
    cases = []
    for kind, first in zip(wanted, firsts, strict=True):
        settings = (first, *_further(draw, kind, first, letters))
        cases.append(hidden_case(draw, kind, settings, measured))
    strong = [i for i, c in enumerate(cases) if c.kind == "above 7" and len(c.settings) == 1]
    chosen = set(draw.permutation(strong)[:held_out].tolist())
    return cases, [i in chosen for i in range(len(cases))]


def _further(draw: Generator, kind: str, first: str, letters: Sequence[str]) -> list[str]:
    """The settings of the further flights: other maneuvers of the same airplane."""
    number = int(draw.choice([1, *SEVERAL], p=[1.0 - sum(SEVERAL.values()), *SEVERAL.values()]))
    if kind == "counted":
        return []
    maneuver = SETTINGS[first].flown.maneuver
    others = [letter for letter in letters if SETTINGS[letter].flown.maneuver != maneuver]
    return [str(letter) for letter in draw.permutation(others)[: number - 1]]


def generate(seed: int, jobs: int, folder: Path, small: bool = False) -> str:
    """Seal the truth, then write the logs; return the salted SHA-256. A `small` set has strong causes
    and outsiders alone, in half of the settings, and no flight held out.

    A set that is there already is drawn again and completed. Raises ValueError for a seed of
    neither range, and for another truth.
    """
    if not (DEVELOPMENT_SEEDS[0] <= seed < DEVELOPMENT_SEEDS[1] or seed >= SCORED):
        ranges = f"seeds of development lie in {DEVELOPMENT_SEEDS}, scored ones begin at {SCORED}"
        raise ValueError(ranges)
    known = SMALL_SETTINGS if small else SETTINGS
    letters = [letter for letter in known if (PLACE / f"{letter}.npz").is_file()]
    measured = {letter: read(letter) for letter in letters}
    kinds, held_out = (SMALL, 0) if small else (KINDS, HELD_OUT)
    drawn = draw_set(np.random.default_rng(seed), kinds, letters, measured, held_out)
    cases = seeded(seed, *drawn)
    digest = seal(folder / "seal", seed, told_of(cases))
    print(f"sealed, SHA-256 {digest}", flush=True)
    for name, why in write_logs(folder, cases, SeededCase.flights, jobs).items():
        print(f"{name} cannot be flown: {why}", flush=True)
    return digest


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Draw a set, seal its truth, and write its logs. First measure the `blind signatures`."""
    parser.add_argument("--seed", type=int, default=SCORED)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--small", action="store_true", help="200 cases in half of the settings")
    options = parser.parse_args(words)
    generate(options.seed, options.jobs, OUT / "blind", options.small)
