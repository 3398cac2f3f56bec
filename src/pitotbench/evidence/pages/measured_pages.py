"""Pages under docs/ with the results of campaigns other than the coverage campaign."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime

import pandas as pd

from pitotbench.show.columns import frame_columns, frame_rows, markdown_table

_PEERS = """# The bound compared with published ones

Every row is fitted to the same flights: {count} a maneuver (seeds {first} to {last}, {date:%Y-%m-%d}), light
turbulence, random wind and Inverse+ error. `python scripts/compare_bounds.py --seeds {count}` repeats it. A ±2σ
bound should contain 95 % of the curve.

- *white residuals*: Cramér-Rao bound of output error for uncorrelated residuals (Klein and Morelli 2006).
- *colored residuals, all lags*: that bound with the autocorrelation of the residual (Morelli and Klein 1997).
- *HAC*: the same with a Bartlett window (Newey and West 1987).
- *1 Hz filter of wind and scale*: an extended Kalman filter as small autopilots run it.
- *per-point spread, fixed speed*: legs or turns at one speed each, bounded by twice their scatter (points, not the
  whole curve; no row where a maneuver holds no speed).
- *pitotbench*: `two_sigma_kt`. For the last row the noise's levels and length are given, not estimated.

What each costs is in [speed.md](speed.md#peers).

{table}

Because it has to estimate the noise, the bound is {sharpness:.2f} times as wide as for known noise.
"""
_AUTO = """# `--model auto` on curves that no model of the table can represent

Every flight is recorded with {truths} truths ({names}), their parameters random. Seeds {first} to {last},
{turbulence} turbulence, {das} Hz, {date:%Y-%m-%d}. A ±2σ bound should contain 95 % of the curve.
`python scripts/verify_auto.py --maneuver {maneuver} --seeds {count} --first {first}` repeats it.

{table}
"""


def peers_page(table: pd.DataFrame, seeds: Sequence[int]) -> str:
    """The bounds of published methods and of pitotbench, as Markdown."""
    wide = table.pivot_table(index=["maneuver", "das"], columns="bound", values="mean 2σ [kt]")
    sharpness = float((wide["pitotbench"] / wide["pitotbench, if the noise were known"]).mean())
    return _PEERS.format(table=_markdown(table), sharpness=sharpness, **_flown(seeds))


def auto_page(table: pd.DataFrame, truths: Sequence[str], seeds: Sequence[int], asked: Mapping[str, str]) -> str:
    """Models weighed on truths outside their table, as Markdown; `asked` holds maneuver, turbulence and das."""
    names = ", ".join(truths)
    return _AUTO.format(table=_markdown(table), truths=len(truths), names=names, **asked, **_flown(seeds))


def _flown(seeds: Sequence[int]) -> dict[str, object]:
    return {"count": len(seeds), "first": seeds[0], "last": seeds[-1], "date": datetime.now(UTC)}


def _markdown(table: pd.DataFrame) -> str:
    """A frame as a Markdown table, its columns' names as headings, numbers with three digits."""
    return markdown_table(frame_columns(table, ".3g"), frame_rows(table))
