"""Cautions about a campaign's results: rules of the domain, applied to its numbers."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from pitotbench.show.short_answer import ShortAnswer

if TYPE_CHECKING:
    import pandas as pd

_OFTEN_OUTSIDE = 0.7  # share inside ±2σ: a model below it cannot take the shape of the true curve


def remarks(results: "pd.DataFrame | None", answers: Sequence[ShortAnswer]) -> list[str]:
    """Sentences for the top of a page, the most important first. `results` is None for measured logs."""
    of_results = [] if results is None else [*_ranking(results), *_shapes(results)]
    return [*_warnings(answers), *of_results]


def _warnings(answers: Sequence[ShortAnswer]) -> Iterator[str]:
    """Each warning once, with the flights or logs that it belongs to."""
    for text in dict.fromkeys(w for answer in answers for w in answer.warnings):
        subjects = ", ".join(answer.subject for answer in answers if text in answer.warnings)
        yield f"{subjects}: {text}."


def _ranking(results: "pd.DataFrame") -> Iterator[str]:
    """A small residual does not mean a small bound of the curve."""
    if not len(results):
        return
    first = results[results["model"] == results["model"].iloc[0]]
    table = first.groupby(["maneuver", "das"], sort=False).mean(numeric_only=True)
    if len(table) < 2:
        return
    quiet, known = table["residual_two_sigma_kt"].idxmin(), table["two_sigma_kt"].idxmin()
    if quiet != known:
        yield (
            f"{_words(quiet)} has the smallest residual (2σ {_at(table, quiet, 'residual_two_sigma_kt')}), but "
            f"{_words(known)} gives the smallest bound of the curve (mean ±2σ {_at(table, known, 'two_sigma_kt')} "
            f"against {_at(table, quiet, 'two_sigma_kt')}): do not choose a maneuver by its residual."
        )


def _shapes(results: "pd.DataFrame") -> Iterator[str]:
    """A bound holds only where the model can take the shape of the true curve."""
    if not len(results):
        return
    share = results.groupby("model", sort=False)["curve_coverage"].mean()
    stiff = [str(name) for name, value in share.items() if value < _OFTEN_OUTSIDE]
    if stiff and len(share) > 1:
        yield (
            f"The true curve lies outside the ±2σ bound of {' and '.join(stiff)} over much of the range: the bound "
            "says how far noise moves the curve of a model, not whether the model can take the true shape."
        )


def _words(pair: object) -> str:
    maneuver, das = pair if isinstance(pair, tuple) else (pair, "")
    return f"{str(maneuver).replace('_', ' ').capitalize()} at {das} Hz"


def _at(table: "pd.DataFrame", row: object, column: str) -> str:
    return f"{float(table[column].to_dict()[row]):.2f} kt"
