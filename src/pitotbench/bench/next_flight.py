"""Choose the next flight: fly every card by simulation, and rank them by the probability of a name."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from itertools import count
from typing import Any

import numpy as np

from pitotbench.bench.fleet import open_fleet
from pitotbench.bench.flights import flown
from pitotbench.bench.null_flights import Progress, aircraft_model
from pitotbench.bench.reflight import wind_of_log
from pitotbench.bench.rounds import Reconciliation
from pitotbench.catalog import Catalog, UnknownNameError
from pitotbench.reconciliation.discrimination import Doubt, discrimination, doubt_of
from pitotbench.reconciliation.equations import scaled_to
from pitotbench.reconciliation.evidence import LogEvidence
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout, lay_out
from pitotbench.reconciliation.noise import NoiseModel
from pitotbench.reconciliation.null_distribution import NullDistribution, ScoreScale
from pitotbench.reconciliation.null_learning import wander_of
from pitotbench.reconciliation.posterior import CausePosterior
from pitotbench.reconciliation.signatures import FITTED, Signature, residual_change, returns
from pitotbench.reconciliation.verdict import most_probable
from pitotbench.records import BadInputError
from pitotbench.records.case import Case
from pitotbench.records.case_file import write_case
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import AdvisedFlight, CardForecast
from pitotbench.simulation.card import Card
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.simulation.plant import SimulationError
from pitotbench.simulation.sortie import scaled_card
from pitotbench.units import FOOT, SUFFIXES

LEAST_NAME = 0.2  # probability of a name below which a flight is not worth its time: four of five would end without
AS_GOOD = 0.02  # difference of that probability within which the shorter card is flown
VARIED = 2  # best cards whose variants are tried
HIGHER = 4000.0 * FOOT  # a variant flown higher: less power at the same airspeed, and thinner air
# Numbers of a card that are varied, and by which factor: the span of the speeds, bank, sideslip, height, power and
# minutes.
FACTORS = {"speeds": 0.7, "bank": 1.5, "sideslip": 1.5, "climb": 2.0, "step": 1.5, "dwell": 2.0, "dwells": 1.5}
STEEPEST = {"bank": 45.0}  # deg: the steep turn that pilots train
LEAST_SIZE = 0.05  # of the typical size; signatures of smaller sizes would be differences of rounded numbers
DIGITS = 4  # of a varied number


@dataclass(frozen=True, slots=True)
class CardQuestion:
    """What every card is asked: the explanations to part, and what is expected of its log.

    `aircraft` is the analyst's model. `noise`, `wander` and `setting` are those of the last log, `null_scores` the
    scores of its null flights, and `shapes` the fitted shapes of its effects.
    """

    doubt: Doubt
    aircraft: str
    noise: NoiseModel
    wander: Mapping[str, float]
    setting: AnalysisSetting
    shapes: Mapping[str, Mapping[str, float]]
    null_scores: ScoreScale


def next_flight_after(
    found: Reconciliation, progress: Progress | None = None, varied: int = VARIED
) -> AdvisedFlight | None:
    """Return the next flight, where the logs leave a doubt and it is known what was flown; else None.

    There is a doubt where a name is one of a few, or where a gap is likelier than none and not yet sure.
    """
    verdict, last = found.verdict, found.logs[-1]
    doubtful = verdict.kind == "one_of" or (verdict.kind == "no_gap" and verdict.log_bayes_factor > 0.0)
    if not doubtful or last.card is None:
        return None
    together = found.joint.together
    layout = together.namings[-1].layout
    return choose_next_flight(together.posterior, last.log, last.card, layout, last.null, progress, varied)


def choose_next_flight(
    posterior: CausePosterior,
    log: FlightLog,
    card: Case,
    layout: Layout,
    null: NullDistribution,
    progress: Progress | None = None,
    varied: int = VARIED,
) -> AdvisedFlight | None:
    """Return the card whose flight most probably ends in a name, given the posterior of the flights so far.

    `log`, `card`, `layout` and `null` are those of the last flight: the next one is expected to have its data
    system, wind, loading and noise. All maneuvers are tried, then variants of the best `varied` ones. Each costs
    one flight in smooth air and one layout with the signatures of the explanations that are left.
    None where a single set of causes is left, or where no card can be flown.
    """
    doubt = doubt_of(posterior)
    if len(doubt.of_causes()) < 2:
        return None
    question = question_of(doubt, layout, null)
    base = replace(card, wind=wind_of_log(log), effects=(), turbulence="none")
    cases = [replace(base, maneuver=name, card={}) for name in MANEUVERS]
    cases += [base] if base.card else []
    say = progress or (lambda text: None)
    done = count(1)
    with open_fleet(tasks=len(cases)) as fleet:

        def forecasts(some: Sequence[Case]) -> list[tuple[CardForecast, Case]]:
            found = fleet.perform(
                partial(_forecast, question), some, step=lambda: say(f"card {next(done)} for the next flight")
            )
            return [(each, case) for each, case in zip(found, some, strict=True) if isinstance(each, CardForecast)]

        ranked = _ranked(forecasts(cases))
        if ranked and ranked[0][0].name < most_probable() - AS_GOOD:
            more = [variant for _, case in ranked[:varied] for variant in variants_of(case)]
            ranked = _ranked([*ranked, *forecasts(more)])
    if not ranked:
        return None
    parts = ranked[0][0].name >= LEAST_NAME
    case = replace(ranked[0][1], turbulence=card.turbulence)
    best = tuple(each for each, _ in ranked)
    text = case_text(best[0], doubt, case) if parts else ""
    return AdvisedFlight(tuple(doubt.of_causes().items()), best, parts, text, doubt.entropy)


def question_of(doubt: Doubt, layout: Layout, null: NullDistribution) -> CardQuestion:
    """Return what cards are asked after a log that is laid out."""
    model = layout.scene.force_model
    aircraft = "none" if model is None else model.aircraft.name
    return CardQuestion(
        doubt,
        aircraft,
        scaled_to(null.noise, layout),
        wander_of(null, layout.residuals.names),
        layout.setting,
        _shapes_of(layout),
        null.scores,
    )


def advice_of(advised: AdvisedFlight) -> tuple[str, ...]:
    """Return the advice in sentences: the card to fly and the probability of a name, or that none parts."""
    best = advised.best
    causes = ", ".join(dict.fromkeys(cause for causes, _ in advised.causes for cause in causes))
    if not advised.parts:
        return (
            f"no card of this airplane can part {causes}: the best one, {forecast_words(best)}, gives a name with "
            f"a probability of {best.name:.2f}; look at the airplane",
        )
    sentence = (
        f"to part {causes}: fly {forecast_words(best)}, {best.minutes:.0f} minutes; "
        f"the probability of a name after it is {best.name:.2f}"
    )
    second = next((each for each in advised.ranked if each.maneuver != best.maneuver), None)
    if second is None:
        return (sentence,)
    return (sentence, f"the second best is {forecast_words(second)}, with a probability of {second.name:.2f}")


def forecast_words(forecast: CardForecast) -> str:
    """Return a card in words: its maneuver, its changed numbers and its altitude."""
    changes = ", ".join(f"{key} = {value}" for key, value in forecast.card.items())
    return f"{forecast.maneuver}{f' ({changes})' if changes else ''} at {forecast.altitude / FOOT:.0f} ft"


def case_text(forecast: CardForecast, doubt: Doubt, case: Case) -> str:
    """Return the case file of the next flight, with what it is for as comments."""
    causes = [" and ".join(causes) for causes in doubt.of_causes()]
    return (
        f"# the next flight, to part {', '.join(causes)}\n"
        f"# probability of a name after it: {forecast.name:.2f}; recorded minutes: {forecast.minutes:.1f}\n\n"
        f"{write_case(case)}"
    )


def variants_of(case: Case) -> list[Case]:
    """Return the variants of a case: one number of its card changed each, and the same card flown higher."""
    card = scaled_card(case.aircraft, case.maneuver)
    found = [replace(case, altitude=case.altitude + HIGHER)]
    for entry in fields(card):
        if entry.name in FACTORS:
            suffix = str(entry.metadata["suffix"])
            key = f"{entry.name}_{suffix}"
            if key not in case.card:
                found.append(replace(case, card={**case.card, **_varied(card, entry.name, suffix, key)}))
    return found


def _varied(card: Card, name: str, suffix: str, key: str) -> dict[str, Any]:
    """One number of a card, or one list of numbers, times its factor."""
    value, factor, unit = getattr(card, name), FACTORS[name], SUFFIXES[suffix].factor
    most = STEEPEST.get(name, np.inf)

    def changed(one: float) -> float:
        plain = one / unit
        new = plain / factor if plain * factor > most else plain * factor
        return float(f"{new:.{DIGITS}g}")

    if name == "speeds":  # the fast ones slower, none below the slowest
        slow = min(value)
        value = tuple(v / factor for v in (slow + factor * (v - slow) for v in value))
    changes: dict[str, Any] = {key: [changed(v) for v in value] if isinstance(value, tuple) else changed(value)}
    if name == "bank":  # room for the pilot above the bank of the card
        changes["bank_limit_deg"] = changes[key] + (card.bank_limit - value) / unit
    return changes


def _ranked(found: Sequence[tuple[CardForecast, Case]]) -> list[tuple[CardForecast, Case]]:
    """The best card first: of those about as good as the best one the shortest, then the others."""
    ranked = sorted(found, key=lambda pair: (-pair[0].name, pair[0].entropy))
    if not ranked:
        return []
    good = [pair for pair in ranked if pair[0].name > ranked[0][0].name - AS_GOOD]
    first = min(good, key=lambda pair: pair[0].minutes) if ranked[0][0].name >= LEAST_NAME else ranked[0]
    return [first, *(pair for pair in ranked if pair is not first)]


def _forecast(question: CardQuestion, case: Case) -> CardForecast | None:
    """The forecast of a card; None where it cannot be flown, or where its log has other channels."""
    try:
        log = flown(case)
        evidence = evidence_of_card(question, log)
    except (SimulationError, BadInputError, UnknownNameError):
        return None
    if evidence is None:
        return None
    parting = discrimination(question.doubt, evidence)
    minutes = float(log.time[-1] - log.time[0]) / 60.0
    return CardForecast(case.maneuver, dict(case.card), case.altitude, minutes, parting.name, parting.entropy)


def evidence_of_card(question: CardQuestion, log: FlightLog) -> LogEvidence | None:
    """Return the inner products of a log in smooth air with the signatures of the explanations at their sizes.

    None where the log has other channels than the noise.
    """
    layout = lay_out(log, aircraft_model(question.aircraft), question.setting, Catalog("effect", {}))
    if layout.residuals.names != question.noise.names:
        return None
    signatures = []
    for (name, parameter), size in _sizes_of(question.doubt).items():
        effect, shapes = FITTED[name], question.shapes.get(name, {})
        moved = residual_change(effect, layout.scene, effect.complete({**shapes, parameter: size}))
        if moved is not None and np.any(moved):
            signatures.append(Signature(name, parameter, size, moved / size, shapes))
    asked = replace(layout, signatures=tuple(signatures))
    return LogEvidence(asked, question.noise, question.wander, question.null_scores)


def _sizes_of(doubt: Doubt) -> dict[tuple[str, str], float]:
    """The sizes of all explanations, those of the most probable first; none so small that it is rounding.

    Effects that do not return in another flight have none.
    """
    sizes: dict[tuple[str, str], float] = {}
    for contender in doubt.contenders:
        for key, size in zip(contender.keys, contender.sizes.tolist(), strict=True):
            if not returns(key[0]):
                continue
            least = LEAST_SIZE * abs(FITTED[key[0]].parameter(key[1]).typical)
            sizes.setdefault(key, float(np.copysign(max(abs(size), least), size)))
    return sizes


def _shapes_of(layout: Layout) -> dict[str, dict[str, float]]:
    """The fitted shapes of the effects that return in another flight."""
    return {s.effect: dict(s.shapes) for s in layout.signatures if s.shapes and returns(s.effect)}
