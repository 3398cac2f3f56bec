"""The verdict of a reconciliation for the terminal and as plain data, with its tables."""

from dataclasses import asdict
from typing import Any

from pitotbench.effects import EFFECTS, OWN_TERMS, effect_of
from pitotbench.records.gap import Account, Closing, Coefficient, Feature, FlownAgain, Tolerance
from pitotbench.records.verdict import (
    Candidate,
    Closure,
    Detectable,
    Gap,
    JoinedFlight,
    Located,
    Verdict,
)
from pitotbench.show.columns import Column, json_rows
from pitotbench.show.gap_words import features_limit, reported_rivals
from pitotbench.show.plan import LEG_COLUMNS
from pitotbench.show.record import CHECK_COLUMNS
from pitotbench.show.words import listed, name_and_unit, size_words, with_unit, words

KIND_WORDS = {
    "named": "named",
    "one_of": "one of these",
    "unknown": "a gap with a cause that is not in the table",
    "no_gap": "no significant gap",
}

PLACE_COLUMNS: tuple[Column[Located], ...] = (
    Column("channel", lambda place: words(place.channel)),
    Column("phase or variable", lambda place: words(place.where)),
    Column("", lambda place: place.channel, key="channel"),
    Column("", lambda place: place.phase, key="phase"),
    Column("", lambda place: place.variable, key="variable"),
    Column("gap", lambda place: place.significance, "σ", "+.1f", "significance"),
)

DETECTABLE_COLUMNS: tuple[Column[Detectable], ...] = (
    Column("part", lambda found: EFFECTS[found.effect].part),
    Column("effect", lambda found: words(found.effect)),
    Column("smallest size", lambda found: size_words(found.parameter, found.size)),
    Column("", lambda found: found.effect, key="effect"),
    Column("", lambda found: found.parameter, key="parameter"),
    Column("", lambda found: found.size, key="size"),
)

TOLERANCE_COLUMNS: tuple[Column[Tolerance], ...] = (
    Column("quantity", lambda t: t.quantity, key="quantity"),
    Column("tolerance", lambda t: f"±{with_unit(f'{t.half_width:g}', t.unit)}"),
    Column("", lambda t: t.half_width, key="half_width"),
    Column("", lambda t: t.unit, key="unit"),
    Column("before", lambda t: t.before, "%", ".0%", "before"),
    Column("with the patch", lambda t: t.after, "%", ".0%", "after"),
    Column("two flights of one airplane", lambda t: t.by_chance, "%", ".0%", "by_chance"),
)


def _difference(each: Feature, value: float) -> float:
    """Measured minus `value`, in standard deviations between two flights of one airplane."""
    return (each.measured - value) / max(each.deviation, 1e-9)


FEATURE_COLUMNS: tuple[Column[Feature], ...] = (
    Column("segment", lambda f: f.segment),
    Column("quantity", lambda f: f"{f.name} [{f.unit}]"),
    Column("measured", lambda f: f.measured, style=".2f"),
    Column("simulated", lambda f: f.simulated, style=".2f"),
    Column("patched", lambda f: f.patched, style=".2f"),
    Column("measured − simulated", lambda f: _difference(f, f.simulated), "σ", "+.1f"),
    Column("measured − patched", lambda f: _difference(f, f.patched), "σ", "+.1f"),
)


def noticed(features: tuple[Feature, ...]) -> list[Feature]:
    """Return the features that differ, with or without the patch, by more than chance.

    Chance is what two flights of one airplane differ by.
    """
    limit = features_limit(features)
    return [
        f
        for f in features
        if max(abs(f.measured - f.simulated), abs(f.measured - f.patched)) > limit * f.deviation
    ]


def kind_words(verdict: Verdict) -> str:
    """The kind of a verdict in words.

    A set of which one cause alone is worth telling is a doubted name.
    """
    if len(verdict.explained) > 1:
        return f"{len(verdict.explained)} gaps"
    if verdict.kind == "one_of" and not any(reported_rivals(verdict)):
        return "a probable cause"
    if verdict.kind == "one_of" and all(
        effect_of(e.name).part in verdict.named_parts for e in verdict.effects
    ):
        return f"{listed(verdict.named_parts)}: one of these causes"
    return KIND_WORDS[verdict.kind]


def candidate_columns(verdict: Verdict) -> list[Column[Candidate]]:
    """The columns of a verdict's candidates; the last one says which of them the verdict names."""
    results = {
        gap.causes[0].name: "named" if gap.named else "the most probable"
        for gap in verdict.explained
    }
    alternatives = {name for names in verdict.alternatives for name in names}

    def result(each: Candidate) -> str:
        rival = "cannot be distinguished" if effect_of(each.name).cause in alternatives else ""
        return results.get(each.name, rival)

    return [
        Column("effect", lambda each: words(each.name)),
        Column("", lambda each: each.name, key="name"),
        Column("part", lambda each: effect_of(each.name).part, key="part"),
        Column(
            "size (± is 2σ)",
            lambda each: "; ".join(
                size_words(size.name, size.value, size.two_sigma) for size in each.sizes
            ),
        ),
        Column("probability", lambda each: each.probability, style=".2f", key="probability"),
        Column("score", lambda each: each.score, "σ", ".1f", "score"),
        Column("verdict", result),
    ]


def _alone(flight: JoinedFlight) -> str:
    causes = [listed([words(c) for c in group], "or") for group in flight.causes if group]
    return KIND_WORDS[flight.alone] + (f": {'; '.join(causes)}" if causes else "")


def _own(flight: JoinedFlight) -> str:
    sizes = ((own.effect, own.size) for own in flight.own_sizes)
    return "; ".join(
        f"{words(name)}, {size_words(s.name, s.value, s.two_sigma)}" for name, s in sizes
    )


FLIGHT_COLUMNS: tuple[Column[JoinedFlight], ...] = (
    Column("flight", lambda flight: flight.log, key="log"),
    Column("card", lambda flight: words(flight.maneuver) if flight.maneuver else "not known"),
    Column("", lambda flight: flight.maneuver or None, key="maneuver"),
    Column("recorded", lambda flight: flight.minutes, "min", ".1f", "minutes"),
    Column("alone", _alone),
    Column("", lambda flight: flight.alone, key="verdict_alone"),
    Column("", lambda flight: flight.log_bayes_factor, key="log_bayes_factor_alone"),
    Column("own size (± is 2σ)", _own),
    Column(
        "apart from the others",
        lambda flight: max(
            (own.distance for own in flight.own_sizes if own.distance is not None), default=None
        ),
        "σ",
        ".1f",
        "apart",
    ),
    Column("G", lambda flight: flight.closure.share, style=".2f", key="closure"),
    Column(
        "G left out",
        lambda flight: flight.left_out and flight.left_out.share,
        style=".2f",
        key="closure_left_out",
    ),
    Column("", lambda flight: flight.null_flights, key="null_flights"),
)


def flight_json(flight: JoinedFlight) -> dict[str, Any]:
    """What a flight of several says, as plain data."""
    (plain,) = json_rows(FLIGHT_COLUMNS, [flight])
    sizes = [
        {"effect": own.effect, **asdict(own.size), "apart": own.distance}
        for own in flight.own_sizes
    ]
    return plain | {"causes_alone": [list(group) for group in flight.causes], "own_sizes": sizes}


def measured_words(each: Coefficient) -> str:
    """A measured coefficient with its bound and its unit."""
    number = f"{each.measured.value:.4g} ± {each.measured.two_sigma:.2g}"
    return with_unit(number, each.measured.name)


COEFFICIENT_COLUMNS: tuple[Column[Coefficient], ...] = (
    Column("term of the file", lambda each: words(each.effect)),
    Column("size", lambda each: words(each.parameter)),
    Column("", lambda each: each.effect, key="effect"),
    Column("", lambda each: each.parameter, key="parameter"),
    Column("the model's", lambda each: each.model, style=".4g", key="model"),
    Column("measured (± is 2σ)", measured_words),
    Column("", lambda each: each.measured.value, key="measured"),
    Column("", lambda each: each.measured.two_sigma, key="two_sigma"),
    Column("", lambda each: each.measured.name, key="unit"),
    Column("", lambda each: "" if each.has_gap else "no gap"),
    Column("", lambda each: each.has_gap, key="has_gap"),
)


def closing_columns(closing: Closing) -> list[Column[Gap]]:
    """The columns of the gaps of a closed loop; of a term of its file a model has a coefficient."""

    by_effect = {each.effect: each for each in reversed(closing.coefficients)}

    def of_file(gap: Gap) -> Coefficient | None:
        return by_effect.get(gap.causes[0].name)

    def measured(gap: Gap) -> str:
        sizes = [size_words(s.name, s.value, s.two_sigma) for s in gap.causes[0].sizes]
        found = of_file(gap)
        return "; ".join(sizes if found is None else [measured_words(found), *sizes])

    return [
        Column("part", lambda gap: gap.part or "no part of the table"),
        Column("coefficient or effect", lambda gap: words(gap.causes[0].name)),
        Column(
            "the model's", lambda gap: "none" if (f := of_file(gap)) is None else f"{f.model:.4g}"
        ),
        Column("measured (± is 2σ)", measured),
        Column("", lambda gap: (found := of_file(gap)) and found.model, key="model"),
        Column("", lambda gap: (found := of_file(gap)) and asdict(found.measured), key="measured"),
        Column("", lambda gap: gap in closing.patched, key="patched"),
        Column("closes held out", lambda gap: min(1.0, gap.closes_held_out), "%", ".0%"),
        Column("done", lambda gap: "patched" if gap in closing.patched else "told"),
        Column("not told from", lambda gap: ", ".join(words(c.name) for c in gap.causes[1:])),
    ]


def closing_json(closing: Closing) -> dict[str, Any]:
    """A closed loop as plain data; a row of its table is a gap, with what was done."""
    done = json_rows(closing_columns(closing), closing.gaps)
    return {
        "aircraft": closing.aircraft if closing.closed else None,
        "closed_held_out": list(closing.closed),
        "closure_holdout": closing.closure_holdout,
        "cut": list(closing.cut),
        "not_told": closing.not_told or None,
        "table": [gap_json(gap) | row for gap, row in zip(closing.gaps, done, strict=True)],
        "left": verdict_json(closing.verdict),
    }


LEAST_PROBABILITY = 0.001  # of a cause that is listed


def verdict_json(verdict: Verdict) -> dict[str, Any]:
    """The verdict as plain data; the gap as sums of squares in units of the noise."""
    return {
        "verdict": verdict.kind,
        "gaps": [gap_json(gap) for gap in verdict.gaps],
        "free": [asdict(each) for each in verdict.free],
        "remains": verdict.remains,
        "doubts": list(verdict.doubts),
        "probabilities": {
            name: p for name, p in verdict.probabilities.items() if p > LEAST_PROBABILITY
        },
        "log_bayes_factor": verdict.log_bayes_factor,
        "candidates": json_rows(candidate_columns(verdict), verdict.candidates),
        "gap_before": verdict.closure.before,
        "gap_after": verdict.closure.after,
        "gap_noise": verdict.closure.noise,
        "closure": _share(verdict, verdict.closure),
        "closure_holdout": _share(verdict, verdict.closure_holdout),
        "located": json_rows(PLACE_COLUMNS, verdict.located),
        "checks": json_rows(CHECK_COLUMNS, verdict.checks),
        "advice": list(verdict.advice),
        "smallest_detectable": json_rows(DETECTABLE_COLUMNS, verdict.smallest_detectable),
        "notes": list(verdict.notes),
    }


def gap_json(gap: Gap) -> dict[str, Any]:
    """A gap as plain data."""
    return {
        "part": gap.part or None,
        "probability": gap.probability,
        "named": gap.named,
        "causes": [_cause(each) for each in gap.causes],
        "closes": gap.closes,
        "closes_held_out": gap.closes_held_out,
    }


def _cause(each: Candidate) -> dict[str, Any]:
    acts_on = effect_of(each.name).acts_on
    sizes = {"sensors": "sensor"}.get(acts_on, acts_on)
    return {
        "name": each.name,
        "acts_on": "file" if each.name in OWN_TERMS or "/" in each.name else sizes,
        "probability": each.probability,
        "parameters": [asdict(s) | {"unit": name_and_unit(s.name)[1]} for s in each.sizes],
        "times": dict(each.times),
        "score": each.score,
    }


def account_json(account: Account) -> dict[str, Any]:
    """The verdict, the patch and the card flown again, as plain data."""
    return verdict_json(account.verdict) | {
        "patch": [{"name": name, "parameters": dict(sizes)} for name, sizes in account.entries],
        "waterfall": [asdict(step) for step in account.waterfall],
        "flown_again": _flown(account.flown),
        "null_flights": account.null_flights,
        "flights": [flight_json(flight) for flight in account.flights],
        "warnings": list(account.warnings),
        "coefficients": json_rows(COEFFICIENT_COLUMNS, account.coefficients),
        "chosen": account.chosen or None,
        "closed": account.closing and closing_json(account.closing),
        "next_maneuver": account.following or None,
        "pilot_card": json_rows(LEG_COLUMNS, account.legs),
    }


def _flown(flown: FlownAgain) -> dict[str, Any]:
    return {
        "skipped": flown.skipped or None,
        "pilot": flown.pilot or None,
        "within_tolerance": json_rows(TOLERANCE_COLUMNS, flown.tolerances),
    }


def _share(verdict: Verdict, closed: Closure | None) -> float | None:
    return closed.share if closed is not None and any(g.causes for g in verdict.gaps) else None
