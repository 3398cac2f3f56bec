"""Draw what CPU time grows like: one line a job on logarithmic axes, with the fitted exponent."""

from collections.abc import Sequence
from pathlib import Path

from pitotbench.evidence.speed.growth import Cost, exponent
from pitotbench.show.style import BLUE, GREEN, ORANGE, canvas

_COLORS = {"read": BLUE, "calibrate": ORANGE, "campaign": GREEN}


def draw_growth(costs: Sequence[Cost], path: Path) -> None:
    """Write a picture of CPU time against samples and against flights."""
    with canvas(1, 2, 9.0, 3.4) as (figure, (samples, flights)):
        for job, color in _COLORS.items():
            own = [cost for cost in costs if cost.job == job]
            if not own:
                continue
            axes = flights if job == "campaign" else samples
            label = f"{job}, exponent {exponent(own):.2f}"
            axes.loglog([c.size for c in own], [c.seconds for c in own], "o-", color=color, ms=4, label=label)
        for axes, what in ((samples, "samples of the log [rows]"), (flights, "flights of the campaign [flights]")):
            axes.set(xlabel=what, ylabel="CPU time [s]")
            if axes.lines:
                axes.legend()
        figure.savefig(path, dpi=130)
