"""What is hidden in each log: drawn from a seed, in shares that fill the rows of the score table."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from tests.blind.forms import FORMS, KNOWN_AND_HIDDEN
from tests.blind.outside import FAULTS
from tests.blind.signals import typical

from pitotbench.effects import EFFECTS

KINDS = {
    "none": 0.20,
    "above 7": 0.19,
    "4 to 7": 0.15,
    "2 to 4": 0.11,
    "confusable": 0.11,
    "two": 0.11,
    "outside": 0.10,
}
KINDS["gusts or samples"] = 1.0 - sum(KINDS.values())
BANDS = {"above 7": (8.0, 25.0), "4 to 7": (4.3, 6.7), "2 to 4": (2.2, 3.8), "confusable": (5.0, 15.0)}
BANDS |= {"two": (5.0, 20.0), "outside": (8.0, 25.0)}
GROUPS = (  # effects that are easily taken for each other
    ("pitot_lag", "air_data_latency", "gps_latency", "clock_drift", "one_way_lag", "wandering_latency"),
    ("static_lag", "line_leak", "static_zero_offset"),
    ("belly_pod", "gear_not_up", "induced_drag", "flap_not_up", "cubed_induced_drag", "slow_pod"),
    ("time_drift", "temperature_drift", "wind_drift", "late_drift", "curved_wind_drift"),
    ("power_deficit", "propeller_efficiency", "friction_loss", "belly_pod"),
    ("mass", "induced_drag", "alpha_static_error", "center_of_gravity"),
    ("turn_drag", "turn_rate_drag", "induced_drag", "antenna_lever_arm"),
    ("propwash_error", "alpha_static_error", "governor_speed"),
)
COUNTED = {  # sizes of what is counted or shows in the spread only
    "dropped_samples": {"fraction": (0.02, 0.12)},
    "quantization": {"step_pa": (30.0, 80.0)},
    "sample_and_hold": {"period_s": (0.2, 0.6)},
    "saturation": {"ceiling_pa": (3400.0, 4000.0)},
    "turbulence_level": {"change": (0.5, 1.5)},
}
VARIANT_SHARE = 0.3
ENVIRONMENT_SHARE = 0.25


@dataclass(frozen=True, slots=True)
class Hidden:
    """The truth of one log: `effects` with their sizes and `strengths` (SNR, 0 where it has none); `fault` is
    outside the table, `fault_size` its size; `environment` is usual, step or spectrum."""

    kind: str
    card: str
    effects: tuple[tuple[str, Mapping[str, float]], ...]
    strengths: tuple[float, ...]
    fault: str
    fault_size: float
    environment: str


def kinds(draw: Generator, cases: int) -> list[str]:
    """A kind for each case, in random order, in the shares wanted."""
    edges = np.round(np.cumsum(list(KINDS.values())) * cases).astype(int)
    counts = np.diff(edges, prepend=0)
    ordered = [kind for kind, count in zip(KINDS, counts, strict=True) for _ in range(count)]
    return [ordered[i] for i in draw.permutation(len(ordered))]


def hidden(draw: Generator, kind: str, card: str, signals: Mapping[str, float]) -> Hidden:
    """What one log hides. `signals` holds the strength of typical sizes on its card."""
    calm = card.endswith("none")
    environment = (
        ("step" if calm else str(draw.choice(["step", "spectrum"]))) if _by(draw, ENVIRONMENT_SHARE) else "usual"
    )
    effects: list[tuple[str, Mapping[str, float]]] = []
    strengths: list[float] = []
    fault, fault_size = "", 0.0
    if kind == "outside":
        fault, fault_size, strength = _fault(draw, signals)
        strengths = [strength]
    elif kind == "gusts or samples":
        effects, strengths = [_counted(draw, calm)], [0.0]
    elif kind != "none":
        for _ in range(2 if kind == "two" else 1):
            name, sizes, strength = _effect(draw, kind, signals, [e for e, _ in effects])
            effects.append((name, sizes))
            strengths.append(strength)
    return Hidden(kind, card, tuple(effects), tuple(strengths), fault, fault_size, environment)


def _by(draw: Generator, share: float) -> bool:
    return bool(draw.random() < share)


def _strength(draw: Generator, kind: str) -> float:
    low, high = BANDS[kind]
    return float(np.exp(draw.uniform(np.log(low), np.log(high))))


def _fault(draw: Generator, signals: Mapping[str, float]) -> tuple[str, float, float]:
    seen = [name for name in FAULTS if signals[name] > 1.0]
    name = str(draw.choice(seen))
    strength = _strength(draw, "outside")
    size = min(3.0, strength / signals[name])
    return name, size, size * signals[name]


def _counted(draw: Generator, calm: bool) -> tuple[str, dict[str, float]]:
    name = str(draw.choice([n for n in COUNTED if not (calm and n == "turbulence_level")]))
    drawn = {key: float(draw.uniform(*limits)) for key, limits in COUNTED[name].items()}
    return name, EFFECTS[name].typical() | drawn


def _effect(
    draw: Generator, kind: str, signals: Mapping[str, float], taken: list[str]
) -> tuple[str, dict[str, float], float]:
    """An effect whose plausible sizes reach the wanted strength on this card."""
    strength = _strength(draw, kind)
    pool = list(GROUPS[draw.integers(len(GROUPS))]) if kind == "confusable" else _pool(draw)
    fits = [n for n in pool if n not in taken and _same(n) not in map(_same, taken)]
    fits = [n for n in fits if signals.get(n, 0.0) > 0.0 and _within(n, strength / signals[n])]
    if not fits:
        return _effect(draw, kind, signals, taken)
    name = str(draw.choice(fits))
    factor = strength / signals[name]
    shapes = {p.name for p in KNOWN_AND_HIDDEN[name].parameters if p.shape}
    sign = -1.0 if _by(draw, 0.5) and _within(name, -factor) else 1.0
    sizes = {k: v if k in shapes else sign * factor * v for k, v in typical(KNOWN_AND_HIDDEN[name]).items()}
    if "at_s" in sizes:
        sizes["at_s"] = float(draw.uniform(90.0, 210.0))
    if "from_s" in sizes:
        sizes["from_s"] = float(draw.uniform(60.0, 170.0))
    return name, sizes, strength


def _pool(draw: Generator) -> list[str]:
    return list(FORMS if _by(draw, VARIANT_SHARE) else EFFECTS)


def _same(name: str) -> str:
    return KNOWN_AND_HIDDEN[name].cause


def _within(name: str, factor: float) -> bool:
    """Whether all sizes, scaled, lie in their plausible ranges."""
    return all(p.low <= factor * p.typical <= p.high for p in KNOWN_AND_HIDDEN[name].parameters if not p.shape)
