"""The score by part: which part of the airplane or the world a case hides, which one was told, and
how surely.

A told probability of a part is the sum of those of its causes, or what such a sum was worth on
judged sets: a table of a few sums, isotonic, which `python -m pitotlab blind parts --write`
computes from the kept sets.
"""

from argparse import ArgumentParser
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import isotonic_regression

import pitotbench.reconciliation
from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.verdict import part_table
from pitotbench.units import Array, Booleans
from pitotlab.blind.case import NO_ANSWER, SURE, JudgedCase
from pitotlab.blind.sealed import judged_in, kept_sets
from pitotlab.tables import write_figures

# What a mechanic would look at where a fault of the generator is none of the table.
PARTS_OUTSIDE: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("loose_tube", "insect_in_tube", "open_drain"), ("pitot head", "pitot line")),
    **dict.fromkeys(("icing_port", "rain_in_port"), ("static ports and line",)),
    "climb_crosstalk": ("impact transducer", "static ports and line"),
    **dict.fromkeys(
        ("heavy_membrane", "kinked_transducer", "heated_transducer"), ("impact transducer",)
    ),
    "strobe_light": ("static transducer",),
    **dict.fromkeys(
        (
            *(
                "bending_boom",
                "twisting_boom",
                "late_vane",
                "crossed_vanes",
                "vane_in_wake",
                "crossed_gyros",
            ),
            *("warming_accelerometer", "stretched_accelerometer", "shaken_accelerometer"),
            *("leaning_gyro", "erected_pitch", "late_attitude"),
        ),
        ("attitude and vanes",),
    ),
    **dict.fromkeys(
        ("swinging_altitude", "multipath_bursts", "leaping_altitude", "stale_fixes"),
        ("GPS receiver and its clock",),
    ),
    **dict.fromkeys(("stamp_jitter", "sagging_supply"), ("recorder",)),
    **dict.fromkeys(
        ("sun_on_probe", "slow_probe", "exhaust_on_probe", "heated_probe"),
        ("thermometer, or the day",),
    ),
    **dict.fromkeys(
        ("fuel_meter", "slipping_tachometer", "long_manifold_line"), ("engine instruments",)
    ),
    **dict.fromkeys(("bent_elevator_pickup", "floating_rudder"), ("controls and trim",)),
    **dict.fromkeys(("pressure_slope", "wake_encounter"), ("air",)),
    "warm_patches": ("air", "thermometer, or the day"),
    **dict.fromkeys(("cowl_flap_cycling", "fluttering_door", "baggage_door"), ("drag",)),
    **dict.fromkeys(("fuel_slosh", "rolling_tanks"), ("loading",)),
    "bending_wing": ("lift, stability and damping",),
    **dict.fromkeys(("icing_wing", "rain_on_wing"), ("lift, stability and damping", "drag")),
    "surging_engine": ("engine or propeller, a side",),
}
EDGES = (0.0, 0.1, 0.3, 0.5, 0.65, 0.8, 0.9, 1.0)  # of the sums that share a row of the table
PRIOR = 2.0  # parts that are as probable as told, added to each row
LEAST = 5e-4  # probability of a cause that was not written down: half of the least that was
NAMED = 0.9
TABLE = Path(pitotbench.reconciliation.__file__).parent / "part_probability.csv"
Told = Callable[[JudgedCase], Mapping[str, float]]


def part_of(cause: str) -> str:
    """The part of a cause of the table; a cause that the table has no more is a part of its own."""
    return str(EFFECTS[cause].part) if cause in EFFECTS else cause


def hidden_parts(case: JudgedCase) -> set[str]:
    """The parts at which a mechanic finds what was hidden."""
    if case.kind == "outside":
        return {part for effect in case.truth["effects"] for part in PARTS_OUTSIDE[effect["name"]]}
    return set(map(part_of, case.wanted))


def summed(case: JudgedCase) -> dict[str, float]:
    """The probability of each part: the sum of those of its causes, at most 1."""
    found: dict[str, float] = {}
    for cause, p in case.probabilities.items():
        found[part_of(cause)] = min(1.0, found.get(part_of(cause), 0.0) + p)
    return found


def told_by(sums: Array, shares: Array) -> Told:
    """Return what tells the probability of each part by a table; no less than that of its most
    probable cause.
    """

    def told(case: JudgedCase) -> dict[str, float]:
        largest: dict[str, float] = {}
        for cause, p in case.probabilities.items():
            largest[part_of(cause)] = max(largest.get(part_of(cause), 0.0), p)
        return {
            part: max(largest[part], float(np.interp(p, sums, shares)))
            for part, p in summed(case).items()
        }

    return told


def with_a_gap(cases: Sequence[JudgedCase]) -> list[JudgedCase]:
    """The cases with something hidden that has a part to be found, of which the answer tells a gap."""
    return [
        c
        for c in cases
        if (c.is_single or c.kind in ("two", "outside")) and c.verdict not in ("no_gap", *NO_ANSWER)
    ]


def _pairs(
    cases: Sequence[JudgedCase], told: Told, hidden: Callable[[JudgedCase], set[str]]
) -> tuple[Array, Booleans]:
    """Told probabilities, (n,), and whether they are right, (n,). What was hidden and not told is
    improbable.
    """
    pairs = []
    for case in cases:
        found, truth = told(case), hidden(case)
        pairs += [(p, name in truth) for name, p in found.items()]
        # An outsider may have two parts, and one of them suffices.
        pairs += [
            (0.0, True)
            for name in truth - set(found)
            if case.kind != "outside" or not truth & set(found)
        ]
    p, right = np.array(pairs, dtype=float).reshape(-1, 2).T
    return p, right > 0.5


def proper_scores(
    cases: Sequence[JudgedCase], told: Told, hidden: Callable[[JudgedCase], set[str]] = hidden_parts
) -> tuple[float, float]:
    """Return the log score and the Brier score a case, each summed over causes or parts: less is
    better.
    """
    p, right = _pairs(cases, told, hidden)
    p = np.clip(p, LEAST, 1.0 - LEAST)
    logs = -np.log(np.where(right, p, 1.0 - p))
    return float(logs.sum()) / len(cases), float(np.sum((p - right) ** 2)) / len(cases)


def fitted_table(cases: Sequence[JudgedCase]) -> tuple[Array, Array, Array]:
    """Return mean sums of rows, (n,), the share right in each, (n,), and the number of parts, (n,).

    Only answers count that name a cause or a set; the shares do not fall (Barlow, Bartholomew,
    Bremner and Brunk 1972). Of no probability nothing is right.
    """
    p, right = _pairs([c for c in with_a_gap(cases) if c.verdict in SURE], summed, hidden_parts)
    number = np.clip(np.searchsorted(EDGES, p, side="right") - 1, 0, len(EDGES) - 2)
    count = np.bincount(number, minlength=len(EDGES) - 1)
    rows = np.flatnonzero(count)
    sums = np.bincount(number, p)[rows] / count[rows]
    shares = (np.bincount(number, right)[rows] + PRIOR * sums) / (count[rows] + PRIOR)
    shares = isotonic_regression(shares, weights=count[rows]).x
    return np.append(0.0, sums), np.append(0.0, shares), np.append(0, count[rows])


@dataclass(frozen=True, slots=True)
class NamedParts:
    """Cases with a part named above 0.9, right and wrong; `first`: the right one is the likeliest."""

    cases: int
    first: int
    right: int
    wrong: int

    def __str__(self) -> str:
        shares = [
            f"{each} ({each / self.cases:.1%})" for each in (self.first, self.right, self.wrong)
        ]
        return "first {}, named above 0.9 right {}, wrong {}".format(*shares) + f", of {self.cases}"


def named_parts(cases: Sequence[JudgedCase], told: Told) -> NamedParts:
    """Count the cases with a right part named, and those with a wrong one; an unknown cause has no
    part.
    """
    first = right = wrong = 0
    for case in cases:
        found, truth = told(case), hidden_parts(case)
        first += bool(found) and max(found, key=lambda part: found[part]) in truth
        named = {part for part, p in found.items() if p > NAMED and case.verdict in SURE}
        right += bool(named & truth)
        wrong += bool(named - truth)
    return NamedParts(len(cases), first, right, wrong)


def strong_causes(cases: Sequence[JudgedCase]) -> list[JudgedCase]:
    """The cases of one flight with a single cause above 7σ."""
    return [
        c
        for c in cases
        if c.is_single and c.flights == 1 and c.band == "above 7" and c.verdict != "not scored"
    ]


def lines(cases: Sequence[JudgedCase], before: Told, after: Told) -> list[str]:
    """The score by part as lines: named parts, and the proper scores over causes and parts."""
    strong = strong_causes(cases)
    outside = [c for c in cases if c.kind == "outside" and c.verdict != "not scored"]
    gap = with_a_gap(cases)
    of_table = [c for c in gap if c.kind != "outside"]
    found = []
    for name, told in (("sum", before), ("table", after)):
        found.append(f"part by the {name}, one flight above 7: {named_parts(strong, told)}")
        found.append(f"part by the {name}, outside the table: {named_parts(outside, told)}")
        for what, some in (("the table", of_table), ("the table and outside", gap)):
            log, brier = proper_scores(some, told)
            found.append(
                f"part by the {name}, causes of {what}: log score {log:.3f}, Brier {brier:.4f}, "
                f"{len(some)}"
            )
    for what, some in (("the table", of_table), ("the table and outside", gap)):
        log, brier = proper_scores(some, lambda c: c.probabilities, lambda c: c.wanted)
        found.append(f"causes of {what}: log score {log:.3f}, Brier {brier:.4f}, {len(some)} cases")
    return found


def kept_table() -> Told:
    """What tells the probability of a part by the table of the product."""
    return told_by(*part_table())


def text_of(sets: Sequence[str], table: tuple[Array, Array, Array]) -> str:
    """The file of a table."""
    head = (
        "# the share of parts that were right, by the sum of the told probabilities; sets "
        f"{' '.join(sets)}"
    )
    rows = [f"{p:.3f},{share:.3f},{n:.0f}" for p, share, n in zip(*table, strict=True)]
    return "\n".join([head, "sum,probability,parts", *rows, ""])


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Fit the table of parts to all kept sets, and show it on sets that it was not fitted to.

    `--page` writes the sum over those sets into docs/how-good-is-it.md.
    """
    parser.add_argument("--write", action="store_true", help="write the table of the product")
    parser.add_argument("--page", action="store_true", help="write the numbers into the page")
    options = parser.parse_args(words)
    names = [path.name.split(".")[0] for path in kept_sets()]
    each = [judged_in(path) for path in kept_sets()]
    half = (len(each) + 1) // 2
    parts = ((slice(0, half), slice(half, None)), (slice(half, None), slice(0, half)))
    held_out = []
    for fitted, other in parts:
        sums, shares, _ = fitted_table([c for some in each[fitted] for c in some])
        print(f"fitted to {' '.join(names[fitted])}, judged on {' '.join(names[other])}")
        judged, told = [c for some in each[other] for c in some], told_by(sums, shares)
        for line in lines(judged, summed, told):
            print(f"  {line}")
        held_out.append(named_parts(strong_causes(judged), told))
    of_both = NamedParts(*(sum(column) for column in zip(*map(astuple, held_out), strict=True)))
    print(f"both, by the table of the other, one flight above 7: {of_both}")
    if options.page:
        share = f"{100.0 * of_both.right / of_both.cases:.0f}"
        numbers = {"part share": share, "parts right": str(of_both.right)}
        numbers |= {"parts": str(of_both.cases), "parts wrong": str(of_both.wrong)}
        write_figures(numbers)
    text = text_of(names, fitted_table([c for some in each for c in some]))
    if options.write:
        TABLE.write_text(text, encoding="utf-8")
    print(text)
