"""The tree of a campaign: its sentences, its table, the short answer of each flight."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from pitotbench.show.calibration import ShortAnswer, is_doubt
from pitotbench.show.columns import Column, frame_rows, keyed
from pitotbench.show.tree import (
    NUMBERS,
    Doubt,
    Figure,
    Heading,
    Node,
    Notice,
    Sentence,
    Table,
)

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


ANSWER_COLUMNS: tuple[Column[ShortAnswer], ...] = (
    Column("flight", lambda answer: answer.subject),
    Column("model", lambda answer: answer.model),
    Column(
        "corrections at low, middle and high speed",
        lambda a: "; ".join(f"{each} at {each.indicated_kt:.0f} KIAS" for each in a.corrections),
    ),
    Column("wind", lambda answer: answer.wind_kt, "kt", ".1f"),
    Column("wind from", lambda answer: answer.wind_from_deg, "°", "03.0f"),
    Column("±2σ of the wind", lambda answer: answer.wind_two_sigma_kt, "kt", ".2f"),
    Column("2σ of the residual", lambda answer: answer.residual_two_sigma_kt, "kt", ".2f"),
)


def campaign_tree(
    results: "pd.DataFrame", answers: Sequence[ShortAnswer] = (), failures: Sequence[str] = ()
) -> list[Node]:
    """The tree of a campaign: what it says, the bound of every flight and the curves over one
    another, the table of its results against the truth, and the short answer of each flight.

    `results` as in results.parquet; `answers` are the first ones; `failures`: a sentence a flight
    that gave no result.
    """
    # The mean over seeds, one row a maneuver, data system and model.
    groups = results.groupby(["maneuver", "das", "model"], sort=False)
    table = groups.mean(numeric_only=True).reset_index()
    plain = table.assign(maneuver=table["maneuver"].str.replace("_", " "))
    one = [f"{each.correction_sentence} {each.wind_sentence}" for each in answers]
    several = len(answers) > 1
    pictures = [
        Figure("pitotbench.show.curves.all_flights_panels", (results,)),
        Figure("pitotbench.show.curves.corrections_panels", (answers,)),
    ]
    return [
        *map(Sentence, one if len(one) == 1 else [*_best(table), *_ranking(results)]),
        *(pictures if several else []),
        *(Doubt(f"failed: {text}") for text in failures),
        *map(Sentence, _shapes(results)),
        *(doubts_of_answers(answers) if several else []),
        Table(CAMPAIGN_COLUMNS, frame_rows(plain), "against the truth, the mean over seeds"),
        *(
            [Heading("Each flight", (Sentence(_ONE), Table(ANSWER_COLUMNS, answers)), NUMBERS)]
            * several
        ),
    ]


def doubts_of_answers(answers: Sequence[ShortAnswer]) -> list[Node]:
    """What some short answers must not go without, each with the flights that it is of."""
    return [
        (Doubt if is_doubt(text) else Notice)(
            f"{', '.join(each.subject for each in answers if text in each.warnings)}: {text}."
        )
        for text in dict.fromkeys(w for answer in answers for w in answer.warnings)
    ]


def _best(table: "pd.DataFrame") -> Iterator[str]:
    """Which maneuver knows the curve best, in one sentence."""
    rows = sorted(frame_rows(table), key=lambda row: float(row["two_sigma_kt"]))
    for best in rows[:1] if len(rows) > 1 else []:
        yield (
            f"{_words((best['maneuver'], best['das']))} knows the curve best: "
            f"±{best['two_sigma_kt']:.2f} kt (mean 2σ of it) in {best['minutes']:.1f} min."
        )


_ONE = "The page of one: pitotbench results DIR --page FLIGHT, with the folder of the campaign."
_LOUD = 1.4  # times the residual at another rate, from which a difference is explained
_OFTEN_OUTSIDE = 0.7  # share inside ±2σ: a model below it cannot take the shape of the true curve


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
