"""How many speeds, how long a step?"""

from collections.abc import Iterator

from pitotbench.show.chart import Lines, LineSeries
from pitotbench.study.evidence import Evidence, Spread
from pitotbench.study.flights import Sortie, case_of
from pitotbench.study.look import COVERING, PAPER, Look
from pitotbench.study.sweeps.sweep import Reply, Sweep

_SPEEDS = {"two": (160.0, 100.0), "three": (160.0, 130.0, 100.0), "six": (160.0, 148.0, 136.0, 124.0, 112.0, 100.0)}
CARDS: dict[str, tuple[str, str, dict[str, object]]] = {
    **{f"{n} speeds, density": ("race_track", f"{n} speeds", {"speeds_kt": s}) for n, s in _SPEEDS.items()},
    **{f"{t:g} s steps, density": ("step_decrease", f"{t:g} s", {"step_time_s": t}) for t in (5.0, 20.0, 40.0)},
}
_LOOKS = (Look("50/50", COVERING), Look("50/50", PAPER))


def sorties(seed: int) -> Iterator[Sortie]:
    """Every card in light turbulence."""
    for variant, (maneuver, _, card) in CARDS.items():
        yield Sortie("light", case_of("light", maneuver, seed, card=card), _LOOKS, variant)


def _answer(evidence: Evidence) -> Reply:
    few = evidence.fit("samples", "race_track", setting="light", variant="two speeds, density").index
    series, points = [], {}
    for maneuver, label, usual in (("race_track", "Race Track, 2 to 6 speeds", "standard"),
                                   ("step_decrease", "Step Decrease, steps of 5 to 40 s", "standard")):  # fmt: skip
        variants = [v for v, (m, _, _) in CARDS.items() if m == maneuver] + [usual]
        found = []
        for variant in variants:
            bound = evidence.fit("two_sigma_kt", maneuver, setting="light", method="covering", variant=variant)
            residual = evidence.residual(maneuver, setting="light", variant=variant)
            minutes = Spread.of(evidence.flight("minutes", maneuver, "light", variant)).mean
            bounds = Spread.of(bound[bound.index.isin(few)])
            found.append((minutes, bounds, Spread.of(residual[residual.index.isin(few)])))
        found.sort(key=lambda item: item[0])
        points[maneuver] = found
        series.append(LineSeries(label, [m for m, _, _ in found], [b.mean for _, b, _ in found],
                                 [b.deviation for _, b, _ in found]))  # fmt: skip
    chart = Lines("What more data buy", "Light turbulence, 50/50 Hz.", "flight time [min]", "covering 2σ of the curve [kt]",
                  series, "sweep-density", log_x=True)  # fmt: skip
    track, step = points["race_track"], points["step_decrease"]
    return Reply(
        f"From {track[0][0]:.0f} to {track[-1][0]:.0f} minutes of Race Track the covering 2σ goes from "
        f"{track[0][1].mean:.2f} to {track[-1][1].mean:.2f} kt while the residual stays at {track[0][2].mean:.2f} to "
        f"{track[-1][2].mean:.2f} kt: the residual cannot tell much data from little. Longer steps of Step Decrease "
        f"({step[0][0]:.0f} to {step[-1][0]:.0f} min) bring it from {step[0][1].mean:.2f} to {step[-1][1].mean:.2f} kt.",
        (chart,),
    )


DENSITY = Sweep("data density", "How many speeds, and how long a step?", _answer, sorties=sorties)
