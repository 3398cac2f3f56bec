"""The tree of a campaign: its sentences, its table, the short answer of each flight."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

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
from pitotbench.show.words import capital, listed, name_and_unit, with_unit
from pitotbench.units import percent_text

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


_CHOICES = ("maneuver", "das", "model")  # in every table of means
_CHOSEN = (*_CHOICES, "calibration")  # by the person; all else that varies is a condition
_NOT_KEYS = {"on_condition_share", "seed", "flight"} | {c.key for c in CAMPAIGN_COLUMNS if c.style}


def keys_of(results: "pd.DataFrame", drawn: Sequence[str] = ()) -> list[str]:
    """Return the columns of results that make a row of their table of means.

    The maneuver, the data system, the model, and all else that takes several values, but for the
    seeds and what is `drawn` at random.
    """
    random = tuple(f"{path}." for path in drawn)
    others = (n for n in map(str, results.columns) if not f"{n}.".startswith(random))
    others = (name for name in others if name not in _NOT_KEYS)
    return [n for n in others if n in _CHOICES or len({*results[n].map(str)}) > 1]


def means_of(results: "pd.DataFrame", drawn: Sequence[str] = ()) -> "pd.DataFrame":
    """Return the means of results over the seeds and over what is `drawn`.

    A row stands for each combination of all else that varies, in the order of the plan.
    """
    keys, numbers = keys_of(results, drawn), {*results.select_dtypes("number")}
    texts = {name: results[name].map(_text) for name in keys if name not in numbers}
    groups = results.assign(**texts).groupby(keys, sort=False, dropna=False)
    measured = [name for name in results if name in numbers and name not in keys]
    return groups[measured].mean().reset_index()


def _text(value: Any) -> str | None:
    """A value as it stands in a table: a list, such as parameters, with commas."""
    if value is None or isinstance(value, str):
        return value
    return ", ".join(map(str, value)) if hasattr(value, "__iter__") else str(value)


def varied_columns(means: "pd.DataFrame") -> list[Column[dict[str, Any]]]:
    """Return the columns of what varies in a table of means, such as `wind.speed_kt`.

    The maneuver, the data system and the model are in every table.
    """
    names = [n for n in map(str, means.columns) if n not in {*_NOT_KEYS, *_CHOICES}]
    numbers = {*means.select_dtypes("number")}
    return [keyed(n, *name_and_unit(n.replace(".", "_")), "g" * (n in numbers)) for n in names]


def condition_of(row: dict[str, Any], varied: Sequence[Column[dict[str, Any]]]) -> str:
    """The conditions under which a row was flown, such as `Wind speed 20 kt`; empty for one."""
    named = (
        f"{key.heading} {with_unit(key.text(row), key.unit)}"
        for key in varied
        if key.key not in _CHOSEN
    )
    return capital(", ".join(named))


def campaign_tree(
    results: "pd.DataFrame",
    answers: Sequence[ShortAnswer] = (),
    failures: Sequence[str] = (),
    drawn: Sequence[str] = (),
) -> list[Node]:
    """Return the tree of a campaign.

    What it says, the bound of every flight and the curves over one another, the table of its
    results against the truth, and the short answer of each flight.

    `results` as in results.parquet; `answers` are the first ones; `failures`: a sentence a flight
    that gave no result. `drawn` as for `means_of`.
    """
    table = means_of(results, drawn)
    varied = varied_columns(table)
    columns = [*CAMPAIGN_COLUMNS[:3], *varied, *CAMPAIGN_COLUMNS[3:]]
    over = listed(["seeds", *(name_and_unit(name.replace(".", "_"))[0] for name in drawn)])
    plain = table.assign(maneuver=table["maneuver"].str.replace("_", " "))
    one = [f"{each.correction_sentence} {each.wind_sentence}" for each in answers]
    several = len(answers) > 1
    pictures = [
        Figure("pitotbench.show.campaign_panels.minutes_panels", (results, drawn), "single"),
        Figure("pitotbench.show.campaign_panels.maneuver_curve_panels", (answers,), "narrow"),
    ]
    return [
        *map(Sentence, one if len(one) == 1 else _best(table, varied)),
        *(pictures if several else []),
        *(Doubt(f"failed: {text}") for text in failures),
        *map(Sentence, [*([] if len(one) == 1 else _ranking(table)), *_shapes(results)]),
        *(doubts_of_answers(answers) if several else []),
        Table(columns, frame_rows(plain), f"against the truth, the mean over {over}"),
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


MOST_CONDITIONS = 6  # that have a sentence each; the table has all


def _best(table: "pd.DataFrame", varied: Sequence[Column[dict[str, Any]]]) -> Iterator[str]:
    """Give for each condition flown the maneuver with the narrowest bound, and its truth."""
    every: dict[str, list[dict[str, Any]]] = {}
    for row in frame_rows(table):
        every.setdefault(condition_of(row, varied), []).append(row)
    for condition, rows in [*every.items()][:MOST_CONDITIONS] if len(table) > 1 else []:
        sentence = _best_of(sorted(rows, key=lambda row: float(row["two_sigma_kt"])), table)
        yield f"{condition}: {sentence}" if condition else sentence


def _best_of(rows: Sequence[dict[str, Any]], table: "pd.DataFrame") -> str:
    """Return in words the narrowest bound of some rows, and the narrowest that the truth bears out.

    The rows come with the narrowest first.
    """
    first, holding = rows[0], [row for row in rows if _holds(row)]
    truth = f"twice its true rms error is {2.0 * first['curve_rms_error_kt']:.2f} kt"
    if len(rows) == 1:
        return f"{_choice(first, table)} has a bound of {_bound(first)}; {truth}."
    if _holds(first):
        return f"{_choice(first, table)} has the narrowest bound: {_bound(first)}; {truth}."
    said = (
        f"{_choice(first, table)} claims the narrowest bound, {_bound(first)}, which the truth "
        f"contradicts: {truth}, and {percent_text(first['curve_coverage'])} of the true curve is "
        "inside"
    )
    if not holding:
        return f"{said}. No bound of the others holds twice its true error."
    narrowest = f"{_choice(holding[0], table)}, {_bound(holding[0])}"
    return f"{said}. The narrowest that the truth bears out: {narrowest}."


def _holds(row: dict[str, Any]) -> bool:
    """Whether a bound (2σ) holds twice the rms error that it had."""
    return float(2.0 * row["curve_rms_error_kt"]) <= float(row["two_sigma_kt"])


def _bound(row: dict[str, Any]) -> str:
    return f"±{row['two_sigma_kt']:.2f} kt (mean 2σ) in {row['minutes']:.1f} min"


def _choice(row: dict[str, Any], table: "pd.DataFrame") -> str:
    """Return what was chosen: maneuver, data system, and model and calibration if several."""
    others = [str(row[n]) for n in ("model", "calibration") if n in table and len({*table[n]}) > 1]
    return " ".join([_words((row["maneuver"], row["das"])), *(f"({n})" for n in others if n)])


_ONE = "The page of one: pitotbench results DIR --page FLIGHT, with the folder of the campaign."
_LOUD = 1.4  # times the residual at another rate, from which a difference is explained
_OFTEN_OUTSIDE = 0.7  # share inside ±2σ: a model below it cannot take the shape of the true curve


def _ranking(means: "pd.DataFrame") -> Iterator[str]:
    """Give what a small residual does not mean: a small bound of the curve.

    Nothing where several conditions were flown; of several models the first.
    """
    table = means[means["model"] == means["model"].iloc[0]].set_index(["maneuver", "das"])
    if len(table) < 2 or not table.index.is_unique:
        return
    quiet, known = table["residual_two_sigma_kt"].idxmin(), table["two_sigma_kt"].idxmin()
    for _, rows in table["residual_two_sigma_kt"].groupby(level="maneuver", sort=False):
        if rows.max() > _LOUD * rows.min():
            yield (
                f"{_words(rows.idxmax())} has a residual of {rows.max():.2f} kt, "
                f"{_words(rows.idxmin())} one of {rows.min():.2f} kt: where the airspeed changes "
                "fast, a slow GPS misses what happens between two fixes. The bound allows for it."
            )
    if quiet != known:
        yield (
            f"{_words(quiet)} has the smallest residual (2σ "
            f"{_at(table, quiet, 'residual_two_sigma_kt')}), but {_words(known)} gives the "
            f"smallest bound of the curve (mean ±2σ {_at(table, known, 'two_sigma_kt')} against "
            f"{_at(table, quiet, 'two_sigma_kt')}): do not choose a maneuver by its residual."
        )


def _shapes(results: "pd.DataFrame") -> Iterator[str]:
    """A bound holds only where the model can take the shape of the true curve."""
    share = results.groupby("model", sort=False)["curve_coverage"].mean()
    stiff = [str(name) for name, value in share.items() if value < _OFTEN_OUTSIDE]
    if stiff and len(share) > 1:
        yield (
            f"The true curve lies outside the ±2σ bound of {' and '.join(stiff)} over much of the "
            "range: the bound says how far noise moves the curve of a model, not whether the model "
            "can take the true shape."
        )


def _words(pair: object) -> str:
    maneuver, das = pair if isinstance(pair, tuple) else (pair, "")
    return f"{str(maneuver).replace('_', ' ').capitalize()} at {das} Hz"


def _at(table: "pd.DataFrame", row: object, column: str) -> str:
    return f"{float(table[column].to_dict()[row]):.2f} kt"
