"""How many speeds are needed, and how long must a step be?"""

from collections.abc import Iterator
from dataclasses import dataclass

from pitotbench.evidence.pages.chart_data import Lines, LineSeries
from pitotbench.evidence.study.looks import COVERING, PAPER, Look
from pitotbench.evidence.study.settings import Sortie, case_of
from pitotbench.evidence.study.study_tables import Spread, StudyTables
from pitotbench.evidence.study.sweeps.sweep import Reply, Sweep

CARDS: dict[str, dict[str, dict[str, object]]] = {
    "race_track": {
        "two speeds": {"speeds_kt": (160.0, 100.0)},
        "three speeds": {"speeds_kt": (160.0, 130.0, 100.0)},
    },
    "step_decrease": {f"{t:g} s steps": {"step_time_s": t} for t in (5.0, 20.0, 40.0)},
}
LABELS = {"race_track": "Race Track, 2, 3, 4 speeds", "step_decrease": "Step Decrease, steps of 5 to 40 s"}
_LOOKS = (Look("50/50", COVERING), Look("50/50", PAPER))


def sorties(seed: int) -> Iterator[Sortie]:
    """Yield every card in light turbulence."""
    for maneuver, variants in CARDS.items():
        for variant, card in variants.items():
            yield Sortie("light", case_of("light", maneuver, seed, card=card), _LOOKS, variant)


@dataclass(frozen=True, slots=True)
class Point:
    """One card: its minutes, the covering 2σ of its curve and the 2σ of its residual [kt]."""

    minutes: float
    bound: Spread
    residual: Spread


def _points(evidence: StudyTables, maneuver: str) -> list[Point]:
    """Return the cards of a maneuver and the usual one, the shortest first, all with the same seeds."""
    points = []
    few = evidence.residual(maneuver, setting="light", variant=next(iter(CARDS[maneuver]))).index
    for variant in ("standard", *CARDS[maneuver]):
        bound = evidence.fit("two_sigma_kt", maneuver, setting="light", method="covering", variant=variant)
        residual = evidence.residual(maneuver, setting="light", variant=variant)
        minutes = Spread.of(evidence.flight("minutes", maneuver, "light", variant)).mean
        bounds, residuals = (Spread.of(found[found.index.isin(few)]) for found in (bound, residual))
        points.append(Point(minutes, bounds, residuals))
    return sorted(points, key=lambda point: point.minutes)


def _series(label: str, points: list[Point]) -> LineSeries:
    return LineSeries(
        label, [p.minutes for p in points], [p.bound.mean for p in points], [p.bound.deviation for p in points]
    )


def _answer(evidence: StudyTables) -> Reply:
    points = {maneuver: _points(evidence, maneuver) for maneuver in CARDS}
    series = [_series(LABELS[maneuver], found) for maneuver, found in points.items()]
    chart = Lines(
        "What more data buy",
        "Light turbulence, 50/50 Hz.",
        "flight time [min]",
        "covering 2σ of the curve [kt]",
        series,
        "sweep-density",
        log_x=True,
        log_y=True,
    )
    track, step = points["race_track"], points["step_decrease"]
    return Reply(
        f"Race Track with two speeds ({track[0].minutes:.0f} min) has a covering 2σ of {track[0].bound.mean:.2f} "
        "kt; three and four speeds give "
        + " and ".join(f"{p.bound.mean:.3f}" for p in track[1:])
        + f" kt, while the residual stays at {min(p.residual.mean for p in track):.2f} to "
        f"{max(p.residual.mean for p in track):.2f} kt. Longer steps of "
        f"Step Decrease ({step[0].minutes:.0f} to {step[-1].minutes:.0f} min) bring it from "
        f"{step[0].bound.mean:.2f} to {step[-1].bound.mean:.2f} kt.",
        (chart,),
    )


DENSITY = Sweep("data density", "How many speeds, and how long a step?", _answer, sorties=sorties)
