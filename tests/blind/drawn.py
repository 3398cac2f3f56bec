"""What each case hides: drawn from a seed, at typical sizes or at a wanted strength, in a setting."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from tests.blind.flown import Environment, has_wind
from tests.blind.outside_airplane import HIDDEN_EFFECTS, OUTSIDERS
from tests.blind.own_forms import OWN_FORMS
from tests.blind.schedule import Part
from tests.blind.settings import SETTINGS
from tests.blind.signatures import GUSTS, SettingSignatures, typical

from pitotbench.effects import EFFECTS, FORMS, Effect, SensorEffect

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
NOT_TOLD = ("nonstandard_temperature",)  # a gap only where the header tells the day, which no header here does
COUNTED = {  # sizes of what is counted or shows in the spread only
    "dropped_samples": {"fraction": (0.02, 0.12)},
    "quantization": {"step_pa": (30.0, 80.0)},
    "sample_and_hold": {"period_s": (0.2, 0.6)},
    "saturation": {"ceiling_pa": (3400.0, 4000.0)},
    "turbulence_level": {"change": (0.5, 1.5)},
}


@dataclass(frozen=True, slots=True)
class HiddenEffect:
    """An effect with its sizes, its strength (SNR) in each flight of the case, and the part of the flight [s] in
    which it acts; None for all of it."""

    name: str
    sizes: Mapping[str, float]
    strengths: tuple[float, ...]
    part: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class HiddenCase:
    """The truth of one case of one to three flights. `kind` is a band, none, two, outside or counted."""

    kind: str
    settings: tuple[str, ...]
    effects: tuple[HiddenEffect, ...]
    environment: Environment

    @property
    def formed(self) -> bool:
        """Whether form, part, gusts, step or receiver are the generator's own."""
        own = any(effect.name in HIDDEN_EFFECTS or effect.part is not None for effect in self.effects)
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
    return HiddenCase(kind, settings, tuple(effects), _environment(draw, settings, [e.name for e in effects]))


def cause_of(name: str) -> str:
    """The cause of an effect of the table or of the generator; an outsider is its own."""
    return _table()[name].cause


def _table() -> dict[str, Effect]:
    return {**FORMS, **HIDDEN_EFFECTS}


def _by(draw: Generator, share: float) -> bool:
    return bool(draw.random() < share)


def _environment(draw: Generator, settings: Sequence[str], names: Sequence[str]) -> Environment:
    """Half of the cases without a form of their own have a world of their own in one respect or two."""
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
        if cause_of(name) in taken or not all(name in measured[letter].names for letter in settings):
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
        # The observer knows one direction of several sizes: where it is the ceiling, they keep their ratio.
        varied = kind not in WEAK
        sizes = _sizes(draw, name, sign * factor, measured[settings[0]], varied)
        return HiddenEffect(name, sizes, tuple(round(factor * t, 2) for t in typicals), part)


def _pool(draw: Generator, kind: str) -> list[str]:
    if kind == "outside":
        return list(OUTSIDERS)
    if _by(draw, FORM_SHARE):
        return list(OWN_FORMS)
    never = (*GUSTS, *NOT_TOLD)
    seen = [n for n, e in EFFECTS.items() if n not in never and not (isinstance(e, SensorEffect) and e.after_noise)]
    return [n for n in seen if n not in HIDDEN_EFFECTS]


def _factor(draw: Generator, kind: str, whole: float) -> float:
    """The factor on typical sizes. Where no band is asked for, sizes are typical, in bounds of strength."""
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
    return whole * float(np.sqrt(np.sum(Part(*part)(signatures.time) * unit) / max(1e-12, np.sum(unit))))


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
    return all(p.low <= factor * p.typical <= p.high for p in _table()[name].parameters if not p.shape)
