"""The table of a campaign, and cautions about its results."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from pitotbench.show.calibration import ShortAnswer
from pitotbench.show.columns import frame_rows, keyed
from pitotbench.show.tree import Node, Table

if TYPE_CHECKING:
    import pandas as pd


CAMPAIGN_COLUMNS = (
    keyed("maneuver", "maneuver"),
    keyed("das", "DAS", "Hz"),
    keyed("model", "model"),
    keyed("minutes", "time", "min", ".1f"),
    keyed("samples", "samples", style=",.0f"),
    keyed("residual_two_sigma_kt", "2σ of the residual", "kt", ".2f"),
    keyed("two_sigma_kt", "mean ±2σ of the curve", "kt", ".3f"),
    keyed("curve_rms_error_kt", "true rms error", "kt", ".3f"),
    keyed("wind_error_kt", "wind error", "kt", ".3f"),
    keyed("curve_coverage", "curve inside ±2σ", "%", ".0%"),
)


def campaign_table(results: "pd.DataFrame") -> "pd.DataFrame":
    """The mean over seeds of a campaign's results, one row a maneuver, data system and model."""
    keys = ["maneuver", "das", "model"]
    return results.groupby(keys, sort=False).mean(numeric_only=True).reset_index()


def campaign_tree(results: "pd.DataFrame") -> list[Node]:
    """The campaign's table."""
    table = campaign_table(results)
    plain = table.assign(maneuver=table["maneuver"].str.replace("_", " "))
    return [Table(CAMPAIGN_COLUMNS, frame_rows(plain))]


_LOUD = 1.4  # times the residual at another rate, from which a difference is explained
_OFTEN_OUTSIDE = 0.7  # share inside ±2σ: a model below it cannot take the shape of the true curve


def remarks(results: "pd.DataFrame | None", answers: Sequence[ShortAnswer]) -> list[str]:
    """Sentences for the top of a page, the most important first. `results` is None for measured
    logs.
    """
    lines = []
    for text in dict.fromkeys(w for answer in answers for w in answer.warnings):
        subjects = ", ".join(answer.subject for answer in answers if text in answer.warnings)
        lines.append(f"{subjects}: {text}.")
    return (
        lines
        if results is None or not len(results)
        else [*lines, *_ranking(results), *_shapes(results)]
    )


def _ranking(results: "pd.DataFrame") -> Iterator[str]:
    """A small residual does not mean a small bound of the curve."""
    first = results[results["model"] == results["model"].iloc[0]]
    table = first.groupby(["maneuver", "das"], sort=False).mean(numeric_only=True)
    if len(table) < 2:
        return
    quiet, known = table["residual_two_sigma_kt"].idxmin(), table["two_sigma_kt"].idxmin()
    for _, rows in table["residual_two_sigma_kt"].groupby(level="maneuver", sort=False):
        if rows.max() > _LOUD * rows.min():
            yield (
                f"{_words(rows.idxmax())} has a residual of {rows.max():.2f} kt, "
                f"{_words(rows.idxmin())} one of "
                f"{rows.min():.2f} kt: where the airspeed changes fast, a slow GPS misses what "
                "happens between two "
                "fixes. The bound allows for it."
            )
    if quiet != known:
        yield (
            f"{_words(quiet)} has the smallest residual (2σ "
            f"{_at(table, quiet, 'residual_two_sigma_kt')}), but "
            f"{_words(known)} gives the smallest bound of the curve (mean ±2σ "
            f"{_at(table, known, 'two_sigma_kt')} "
            f"against {_at(table, quiet, 'two_sigma_kt')}): do not choose a maneuver by its "
            "residual."
        )


def _shapes(results: "pd.DataFrame") -> Iterator[str]:
    """A bound holds only where the model can take the shape of the true curve."""
    share = results.groupby("model", sort=False)["curve_coverage"].mean()
    stiff = [str(name) for name, value in share.items() if value < _OFTEN_OUTSIDE]
    if stiff and len(share) > 1:
        yield (
            f"The true curve lies outside the ±2σ bound of {' and '.join(stiff)} over much of the "
            "range: the bound "
            "says how far noise moves the curve of a model, not whether the model can take the "
            "true shape."
        )


def _words(pair: object) -> str:
    maneuver, das = pair if isinstance(pair, tuple) else (pair, "")
    return f"{str(maneuver).replace('_', ' ').capitalize()} at {das} Hz"


def _at(table: "pd.DataFrame", row: object, column: str) -> str:
    return f"{float(table[column].to_dict()[row]):.2f} kt"
