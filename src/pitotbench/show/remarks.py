"""What to keep in mind about a campaign's results: rules of the domain, applied to its numbers."""

from collections.abc import Iterator, Sequence

import pandas as pd

from pitotbench.show.section_content import ShortAnswer

_OFTEN_OUTSIDE = 0.7  # a model whose curve is inside 2σ less often than this cannot take the true shape


def remarks(results: pd.DataFrame, answers: Sequence[ShortAnswer]) -> list[str]:
    """Sentences for the top of a page, the most important first."""
    return [*_warnings(answers), *_ranking(results), *_shapes(results)]


def _warnings(answers: Sequence[ShortAnswer]) -> Iterator[str]:
    """Each warning once, with the subjects that it belongs to."""
    for text in dict.fromkeys(w for answer in answers for w in answer.warnings):
        subjects = ", ".join(answer.subject for answer in answers if text in answer.warnings)
        yield f"{subjects}: {text}."


def _ranking(results: pd.DataFrame) -> Iterator[str]:
    """The smallest residual is not the best-known curve."""
    if not len(results):
        return
    first = results[results["model"] == results["model"].iloc[0]]
    table = first.groupby(["maneuver", "das"], sort=False).mean(numeric_only=True)
    if len(table) < 2:
        return
    quiet, known = table["residual_two_sigma_kt"].idxmin(), table["two_sigma_kt"].idxmin()
    if quiet != known:
        yield (
            f"{_words(quiet)} leaves the smallest residual ({_at(table, quiet, 'residual_two_sigma_kt')}), but "
            f"{_words(known)} knows its curve best (mean 2σ {_at(table, known, 'two_sigma_kt')} against "
            f"{_at(table, quiet, 'two_sigma_kt')}): do not choose a maneuver by its residual."
        )


def _shapes(results: pd.DataFrame) -> Iterator[str]:
    """A bound holds only where the model can take the shape of the true curve."""
    if not len(results):
        return
    share = results.groupby("model", sort=False)["curve_coverage"].mean()
    stiff = [str(name) for name, value in share.items() if value < _OFTEN_OUTSIDE]
    if stiff and len(share) > 1:
        yield (
            f"The true curve lies outside the 2σ of {' and '.join(stiff)} over much of the range: a bound tells "
            "how noise moves a model's curve, not whether the model can take the true shape."
        )


def _words(pair: object) -> str:
    maneuver, das = pair if isinstance(pair, tuple) else (pair, "")
    return f"{str(maneuver).replace('_', ' ').capitalize()} at {das} Hz"


def _at(table: pd.DataFrame, row: object, column: str) -> str:
    return f"{float(table[column].to_dict()[row]):.2f} kt"
