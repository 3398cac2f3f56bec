"""How often a hidden cause is named: by the measured flight alone, and after the flight that is advised next.

Each development case hides one effect of the table on a card, at a significance drawn between two limits. Its log
is reconciled. Where a doubt is left, the advised card is flown with the same effect hidden in it, and both logs are
reconciled together.
"""

from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from pitotbench.bench.flights import sense
from pitotbench.bench.next_flight import VARIED, next_flight_after
from pitotbench.bench.null_flights import aircraft_model, null_distribution_of
from pitotbench.bench.rounds import NamedLog, reconcile_logs
from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.equations import whitened_equations
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.signatures import FITTED, cause_of, columns_of
from pitotbench.records.case import Case, EffectSpec
from pitotbench.records.case_file import read_case
from pitotbench.records.verdict import Verdict
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.sortie import fly
from pitotlab.experiment import say

SYSTEM = "50/50"
SEED = 41_000  # development seeds: those of scored flights begin at 600,000
BANDS = {"4 to 7": (4.3, 6.7), "above 7": (8.0, 25.0)}
# Effects that circle and rapid deceleration confuse with others; none of the air, whose days differ.
CONFUSED = (
    "belly_pod",
    "turn_drag",
    "induced_drag",
    "gps_latency",
    "clock_drift",
    "pitot_lag",
    "alpha_static_error",
    "static_source_change",
    "power_deficit",
    "propeller_efficiency",
    "trim_offset",
    "antenna_lever_arm",
)
CARDS = ("circle", "rapid_decel")


@dataclass(frozen=True, slots=True)
class Tried:
    """A case: what was hidden, its significance [σ], the answers, and the card that was advised."""

    effect: str
    strength: float
    band: str
    card: str
    advised: str
    promised: float
    alone: str
    after: str


def cases(effects: Sequence[str] = CONFUSED, cards: Sequence[str] = CARDS) -> Iterator[tuple[str, str, str, int]]:
    """Give effect, card, band and seed of each case: every effect once, cards and bands in turn."""
    bands = list(BANDS)
    for number, effect in enumerate(effects):
        yield effect, cards[number % len(cards)], bands[(number // len(cards)) % len(bands)], SEED + number


@cache
def strengths(maneuver: str) -> dict[str, float]:
    """Return the significance [σ] of the typical sizes of each effect on a card, from a flight without effects."""
    card = Case(maneuver=maneuver, das=data_system(SYSTEM), turbulence="light")
    log = sense(fly(replace(card, truth_seed=SEED, sensor_seed=SEED)), SYSTEM)
    layout = lay_out(log, aircraft_model(card.aircraft), AnalysisSetting(day_known=True))
    equations = whitened_equations(layout, null_distribution_of(card).noise)
    found = {}
    for name, columns in columns_of(layout.signatures).items():
        typical = np.array([FITTED[name].parameter(layout.signatures[c].parameter).typical for c in columns])
        found[name] = float(np.sqrt(typical @ equations.inner[np.ix_(columns, columns)] @ typical))
    return found


def try_out(
    effect: str,
    maneuver: str,
    band: str,
    seed: int,
    progress: Callable[[str], None] | None = None,
    varied: int = VARIED,
) -> Tried:
    """Hide an effect, reconcile its log, fly the card that is advised, and reconcile both.

    `varied` is the number of cards whose variants are tried: each variant that is advised needs null flights of its
    own.
    """
    plain = Case(maneuver=maneuver, das=data_system(SYSTEM), turbulence="light")
    low, high = BANDS[band]
    drawn = np.random.default_rng(seed)
    strength = float(np.exp(drawn.uniform(np.log(low), np.log(high))))
    factor = strength / strengths(maneuver)[effect]
    shapes = {p.name for p in EFFECTS[effect].parameters if p.shape}
    sizes = {k: v if k in shapes else factor * v for k, v in EFFECTS[effect].typical().items()}
    hidden = (EffectSpec(effect, sizes),)
    flown = fly(replace(plain, effects=hidden, truth_seed=seed, sensor_seed=seed))
    first = NamedLog("first", sense(flown, SYSTEM))
    outcome = reconcile_logs([first], progress=progress)
    alone = _answer(outcome.verdict, effect)
    advised = next_flight_after(outcome, progress, varied)
    if advised is None or not advised.parts:
        return Tried(effect, strength, band, maneuver, "none", 0.0, alone, alone)
    case = replace(read_case(advised.case), effects=hidden, truth_seed=seed + 500, sensor_seed=seed + 500)
    second = NamedLog("second", sense(fly(case), case.das))
    both = reconcile_logs([first, second], progress=progress)
    card = f"{case.maneuver} {dict(case.card) or ''}".strip()
    return Tried(effect, strength, band, maneuver, card, advised.best.name, alone, _answer(both.verdict, effect))


def _answer(verdict: Verdict, effect: str) -> str:
    """The verdict in a word: right, wrong, in the set, or its kind."""
    truth = FITTED[effect].one_model_with or cause_of(effect)
    named = {cause_of(e.name) for e in verdict.effects}
    others = {cause_of(name) for names in verdict.alternatives for name in names}
    if verdict.kind == "named":
        return "right" if named == {truth} else ("right and more" if truth in named else "wrong")
    if verdict.kind == "one_of":
        return "in the set" if truth in named | others else "not in the set"
    return verdict.kind


def case_lines(tried: Sequence[Tried]) -> list[str]:
    """The cases and the shares of right names, as lines."""
    lines = [
        f"{t.effect:22s} {t.card:12s} {t.strength:5.1f}σ  alone: {t.alone:14s} next: {t.advised:40s} "
        f"promised {t.promised:.2f}  after: {t.after}"
        for t in tried
    ]
    for band in BANDS:
        some = [t for t in tried if t.band == band]
        if some:
            alone, after = (sum(getattr(t, a) == "right" for t in some) for a in ("alone", "after"))
            lines.append(f"SNR {band}: right name alone {alone} of {len(some)}, after the advised flight {after}")
    return lines


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Count how often a hidden cause is named by one flight alone, and after the flight that is advised next."""
    parser.add_argument("--only", help="effects to hide, with commas: " + ", ".join(CONFUSED))
    parser.add_argument("--cards", default=",".join(CARDS), help="of the first flight (default: %(default)s)")
    parser.add_argument("--varied", type=int, default=VARIED, help="cards with variants (default: %(default)s)")
    options = parser.parse_args(words)
    wanted = options.only.split(",") if options.only else CONFUSED
    tried = []
    for row in cases(CONFUSED, options.cards.split(",")):
        if row[0] in wanted:
            tried.append(try_out(*row, say, options.varied))
            print(case_lines(tried[-1:])[0], flush=True)
    print("\n".join(case_lines(tried)))
