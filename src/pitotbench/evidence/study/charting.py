"""Make charts with spread bars from numbers by seed."""

from collections.abc import Callable, Sequence

import pandas as pd

from pitotbench.evidence.pages.chart_data import Bars, BarSeries, Lines, LineSeries
from pitotbench.evidence.study.maneuver_names import NAMES, PAPER_ORDER
from pitotbench.evidence.study.study_tables import Spread

CUT = "The axis does not begin at zero; whiskers are ± one standard deviation over seeds."
Number = Callable[[str, str], pd.Series]  # maneuver and kind to numbers by seed


def maneuver_bars(
    name: str,
    title: str,
    note: str,
    ylabel: str,
    kinds: Sequence[tuple[str, str]],
    number: Number,
    maneuvers: Sequence[str] = PAPER_ORDER,
    dots: bool = False,
    top: float | None = None,
) -> Bars:
    """Return a chart with a group of bars, or of dots, for each maneuver and one for each kind (key, label).

    `number(maneuver, key)` gives the values by seed. `top` is where the axis of dots is cut.
    """
    series = []
    for key, label in kinds:
        found = [Spread.of(number(maneuver, key)) for maneuver in maneuvers]
        series.append(BarSeries(label, [s.mean for s in found], [s.deviation for s in found]))
    note = f"{note} {CUT}" if dots else note
    return Bars(title, note, ylabel, [NAMES[m] for m in maneuvers], series, name, dots, top)


def maneuver_lines(
    name: str,
    title: str,
    note: str,
    xlabel: str,
    ylabel: str,
    levels: Sequence[float],
    number: Callable[[str, float], pd.Series],
    maneuvers: Sequence[str] = PAPER_ORDER,
    log_x: bool = False,
    log_y: bool = False,
) -> Lines:
    """Return a chart with a line for each maneuver over levels.

    `number(maneuver, level)` gives the values by seed.
    """
    series = []
    for maneuver in maneuvers:
        found = [Spread.of(number(maneuver, level)) for level in levels]
        y, spread = [s.mean for s in found], [s.deviation for s in found]
        series.append(LineSeries(NAMES[maneuver], levels, y, spread))
    return Lines(title, note, xlabel, ylabel, series, name, log_x, log_y)
