"""Reconcile one or several logs: find their cards, fly the null flights, and reach an answer."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pitotbench.bench.flown_card import as_flown, card_of, has_weather_report
from pitotbench.bench.fly_again import as_the_log_shows, fly_again
from pitotbench.bench.null_cache import Progress
from pitotbench.bench.null_flights import NULL_FLIGHTS, null_distribution_of
from pitotbench.campaigns.flights import briefing
from pitotbench.catalog import Catalog
from pitotbench.effects import FORMULAS
from pitotbench.effects.effect import Effect
from pitotbench.logbook.columns import write_text
from pitotbench.logbook.identity import require_one_airplane
from pitotbench.logbook.same_flight import distinct, recorders
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.models.coefficients import measured_coefficients
from pitotbench.models.maneuver_model import air_model
from pitotbench.reconciliation.fitting import Fitted
from pitotbench.reconciliation.formula import formula_term
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout, lay_out
from pitotbench.reconciliation.maneuvers import floor_left_out, lay_out_maneuvers
from pitotbench.reconciliation.null_distribution import NullDistribution
from pitotbench.reconciliation.other_flights import for_channels, hold_out
from pitotbench.reconciliation.patches import (
    Patch,
    maneuver_to_fly,
    name_in_case,
    patch_of_effects,
    require_choice,
    with_choice,
)
from pitotbench.reconciliation.pictures import (
    calibration_change,
    clearest_channel,
    gap_map,
    traces,
    waterfall,
)
from pitotbench.reconciliation.regression import effect_and_size, is_term
from pitotbench.reconciliation.residuals import AircraftModel
from pitotbench.reconciliation.shown_flight import ShownFlight, largest_gap
from pitotbench.reconciliation.verdict import Judged, agreeing_changes, judge
from pitotbench.records import BadInputError
from pitotbench.records.calibration import Estimate
from pitotbench.records.case import Case, EffectSpec
from pitotbench.records.gap import Account, Coefficient, FlownAgain, FoundFormula
from pitotbench.records.log import Caution, FlightLog, Provenance
from pitotbench.records.maneuver import Maneuvers
from pitotbench.records.outputs import PAGES, require_file
from pitotbench.records.verdict import (
    REPORTED_FROM,
    SURE,
    Candidate,
    Closure,
    Gap,
    JoinedFlight,
    Verdict,
)
from pitotbench.simulation.modified import unpatched

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, slots=True)
class NamedLog:
    """A log, or maneuvers in its place, with its name in reports.

    `card` is the case that was flown; None: that in the log's header.
    """

    name: str
    log: FlightLog | Maneuvers
    card: Case | None = None


@dataclass(frozen=True, slots=True)
class JudgedLog:
    """A prepared log with its null distribution, and the case flown, None without a card."""

    name: str
    log: FlightLog | Maneuvers
    layout: Layout
    null: NullDistribution
    card: Case | None


def judge_logs(
    logs: Sequence[NamedLog],
    aircraft: str = "navajo",
    holdout: FlightLog | Maneuvers | None = None,
    null_flights: int = NULL_FLIGHTS,
    progress: Progress | None = None,
    setting: AnalysisSetting | None = None,
    keep: bool = True,
) -> tuple[list[JudgedLog], Judged]:
    """Find what a model lacks, from one or several logs of one airplane that lacks the same in all.

    Causes and sizes are shared; wind, error curve and sensor biases are each log's own. `aircraft`
    is a name of the hangar, or `none` to judge the sensors alone. With an aircraft model the card
    of each log is flown for its null flights, at the first mass and the height of the log. Without
    any card the noise of the log itself sets the thresholds, which are then wider. Without `keep`
    the cache of null flights is neither read nor written. Raises BadInputError without a log, or
    for a log that cannot be used.
    """
    if not logs:
        raise BadInputError("reconcile needs at least one log")
    require_one_airplane([each.log for each in logs if isinstance(each.log, FlightLog)])
    model = model_of(aircraft, [each.log for each in logs])
    judged_logs = [
        _judged(each, aircraft, model, null_flights, progress, setting, keep) for each in logs
    ]
    return judged_logs, judge_layouts(judged_logs, model, holdout)


def model_of(aircraft: str, logs: Sequence[FlightLog | Maneuvers]) -> AircraftModel | None:
    """Return the model of an aircraft for logs; of maneuvers it is that of the air alone.

    Raises BadInputError for maneuvers together with logs, or without an aircraft.
    """
    several = [each for log in logs if isinstance(log, Maneuvers) for each in log.maneuvers]
    if not several:
        return aircraft_model(aircraft)
    if not all(isinstance(log, Maneuvers) for log in logs):
        raise BadInputError(
            "a flight log together with maneuvers of system identification: judge them separately"
        )
    if aircraft == "none":
        raise BadInputError("--aircraft none has no aerodynamic terms: name the aircraft")
    return air_model(aircraft, several)


def prepare_layout(
    log: FlightLog | Maneuvers,
    model: AircraftModel | None,
    setting: AnalysisSetting,
    effects: Catalog[Effect] | None = None,
) -> Layout:
    """Lay out a log or maneuvers; `effects` are the hypotheses. Raises as `lay_out`."""
    if isinstance(log, Maneuvers):
        assert model is not None  # maneuvers have one
        return lay_out_maneuvers(log.maneuvers, model, setting, effects)
    return lay_out(log, model, setting, effects)


def judge_layouts(
    judged_logs: Sequence[JudgedLog],
    model: AircraftModel | None,
    holdout: FlightLog | Maneuvers | None,
) -> Judged:
    """Return the answer on logs that are prepared, with their null distributions."""

    return judge(
        [each.name for each in judged_logs],
        [each.layout for each in judged_logs],
        [each.null for each in judged_logs],
        [each.card.maneuver if each.card else "" for each in judged_logs],
        None if holdout is None else partial(closure_on, holdout, model, judged_logs[0]),
    )


def closure_on(
    log: FlightLog | Maneuvers, model: AircraftModel | None, first: JudgedLog, fitted: Fitted
) -> Closure | None:
    """Return the closure of a fit on another log, None where it shows no gap.

    The log has the floor of the `first`.
    """
    prepare = partial(prepare_layout, log, model, first.layout.setting)
    return hold_out(prepare, first.null, fitted)


def _judged(
    named: NamedLog,
    aircraft: str,
    model: AircraftModel | None,
    null_flights: int,
    progress: Progress | None,
    setting: AnalysisSetting | None,
    keep: bool,
) -> JudgedLog:
    """Lay a log out, and take the null distribution of its card, of maneuvers their own floor."""
    if isinstance(named.log, Maneuvers):
        setting = replace(setting or AnalysisSetting(), terms=True, maneuvers=True)
        layout = prepare_layout(named.log, model, setting)
        floor = floor_left_out(layout, named.log.maneuvers)
        return JudgedLog(named.name, named.log, layout, floor, None)
    flown = named.card or (card_of(named.log.header, aircraft) if model is not None else None)
    # The floor of a patched airplane is taken for that before the patch: a patch costs no null
    # flights. It is assumed to move the floor by less than what few null flights leave open.
    null_card = flown
    if flown is not None and model is not None:
        null_card = as_flown(replace(flown, aircraft=unpatched(flown.aircraft)), named.log)
        flown = as_flown(flown, named.log)
    setting = replace(
        setting or AnalysisSetting(),
        day_known=flown is not None
        and (named.card is not None or has_weather_report(named.log.header)),
        instruments_known=flown is not None,
    )
    of_card = (
        null_distribution_of(null_card, null_flights, progress, setting, keep)
        if null_card is not None
        else None
    )
    layout = lay_out(named.log, model, setting)
    return JudgedLog(named.name, named.log, layout, for_channels(of_card, layout), flown)


@dataclass(frozen=True, slots=True)
class FullReconciliation:
    """The reconciliation of logs: the answer, what it follows from, its account and its patch.

    The account is for a report. The record shows itself in a notebook as its account does: in
    words, as a picture and as a table of the causes. `logs` are those that were judged.
    `provenance`: the files and the choices behind the answer, where the caller stated them.
    """

    logs: tuple[JudgedLog, ...]
    judged: Judged
    account: Account
    patch: Patch
    provenance: Provenance = field(default_factory=Provenance)

    @property
    def verdict(self) -> Verdict:
        """The answer."""
        return self.account.verdict

    @property
    def probabilities(self) -> Mapping[str, float]:
        """The probability of each cause."""
        return self.verdict.probabilities

    @property
    def sizes(self) -> Mapping[str, tuple[Estimate, ...]]:
        """The sizes of the named effects, each with its 2σ, in the units of the effects table."""
        return {effect.name: effect.sizes for effect in self.verdict.effects}

    @property
    def flights(self) -> tuple[JoinedFlight, ...]:
        """What each flight says."""
        return self.account.flights

    def write_page(self, path: str | Path, units: str = "") -> None:
        """Write the report as a page (.html), in `units` such as `km/h,m`.

        Raises BadInputError for another name and for words that are no units.
        """
        from pitotbench.show.reader_units import reader_units
        from pitotbench.show.verdict_tree import account_page

        require_file(Path(path), PAGES)
        write_text(Path(path), account_page(self.account, reader_units(units)))

    def write_record(self, path: str | Path, units: str = "") -> None:
        """Write the record for the file (.html), as `reconcile --record` does.

        `units` and errors as for `write_page`.
        """
        from pitotbench.show.reader_units import reader_units
        from pitotbench.show.verdict_tree import reconciliation_record

        require_file(Path(path), PAGES)
        write_text(
            Path(path), reconciliation_record(self.account, self.provenance, reader_units(units))
        )

    def to_frame(self) -> "DataFrame":
        """Return the causes as a table, the most probable first."""
        return self.account.to_frame()

    def plot(self, axes: Any = None) -> Any:
        """Draw the causes' probabilities on matplotlib's axes or new ones; return the figure."""
        return self.account.plot(axes)

    def _repr_html_(self) -> str:
        return self.account._repr_html_()

    def __repr__(self) -> str:
        return repr(self.account).replace(type(self.account).__name__, type(self).__name__, 1)


def reconcile_fully(
    measured: NamedLog | Sequence[NamedLog],
    aircraft: str = "navajo",
    holdout: NamedLog | None = None,
    card: Case | None = None,
    progress: Progress | None = None,
    setting: AnalysisSetting | None = None,
    refly: bool = True,
    keep: bool = True,
    choose: str = "",
) -> FullReconciliation:
    """Reconcile logs, and fly a card again with what is found.

    `card` is that of all logs that state none of their own. `choose` is the cause to patch of a set
    that the logs do not tell apart. With `refly` the card of the log with the largest gap is flown
    again. Without `keep` the cache of null flights is neither read nor written. Raises
    BadInputError for a log that cannot be used, and for a choice that is in no set.
    """
    say = progress or (lambda text: None)
    several = [measured] if isinstance(measured, NamedLog) else measured
    logs, notices = _each_flight_once([replace(e, card=e.card or card) for e in several], holdout)
    for notice in notices:
        say(notice)
    other = holdout.log if holdout else None
    judged_logs, judged = judge_logs(
        logs, aircraft, other, progress=progress, setting=setting, keep=keep
    )
    verdict, source = judged.verdict, ", ".join(each.name for each in logs)
    formula = formula_of(judged)
    require_choice(verdict.gaps, choose)
    patched = [with_choice(gap, choose) for gap in verdict.gaps]
    patch = patch_of(judged, source, datetime.now(UTC).strftime("%Y-%m-%d"), patched)
    effects = entries(patch)
    shown = largest_gap(judged.shown)
    main = next(i for i, each in enumerate(judged.shown) if each is shown)
    refly = refly and aircraft != "none"
    flown = FlownAgain(
        skipped="no aircraft model to fly it with" if aircraft == "none" else "not asked for"
    )
    if refly:
        say("flying the card again")
        again = as_the_log_shows(judged_logs[main].card, shown)
        flown = fly_again(judged_logs[main].log, again, effects)
    # Who flew no card of the bench gets none to fly: the advice says what the next flight needs.
    cards = [each.card.maneuver for each in judged_logs if each.card and each.card.maneuver]
    groups = [tuple(c.name for c in gap.causes) for gap in verdict.explained if refly and cards]
    following = maneuver_to_fly(groups, cards)
    block, fit = shown.block, shown.fit
    found = {effect_and_size(member.name)[0] for member in judged.fitted.members}
    over_time = traces(block, fit)
    part = verdict.explained[0].part if verdict.explained else ""
    has_gap = verdict.kind != "no_gap" and bool(verdict.located)
    account = Account(
        log=source,
        aircraft=aircraft,
        holdout=holdout.name if holdout else "",
        verdict=verdict,
        gap_map=gap_map(block, fit),
        waterfall=waterfall(block, fit, found) if verdict.kind in SURE else (),
        traces=over_time,
        patch=patch.text,
        entries=patch.entries,
        flown=flown,
        null_flights=block.null.flights,
        formula=formula,
        flights=tuple(
            replace(flight, maneuver=each.card.maneuver if each.card else "")
            for flight, each in zip(judged.flights, judged_logs, strict=True)
        ),
        telling=clearest_channel(block, part, over_time) if has_gap else None,
        calibration=calibration_change(block.layout, fit) if verdict.kind in SURE else None,
        warnings=(
            *notices,
            *reported_warnings([*logs, *([holdout] if holdout else [])], verdict),
        ),
        chosen=choose,
        coefficients=coefficients_along(
            aircraft, shown, verdict.gaps, agreeing_changes(judged.fitted)
        ),
        following=following,
        legs=briefing(aircraft, following),
    )
    return FullReconciliation(tuple(judged_logs), judged, account, patch)


def _each_flight_once(
    logs: Sequence[NamedLog], holdout: NamedLog | None
) -> tuple[list[NamedLog], tuple[Caution, ...]]:
    """The logs without those that hold a flight once more, and what is said of these.

    Raises BadInputError for two recorders of one flight, whose gaps are one evidence and not two,
    and for a holdout that is no other flight.
    """
    flights = [log for each in logs if isinstance(log := each.log, FlightLog)]
    if len(flights) < len(logs):  # maneuvers, which are never joined with logs
        return list(logs), ()
    found = distinct(flights, [each.name for each in logs])
    kept = [
        replace(logs[place], log=log) for place, log in zip(found.first, found.logs, strict=True)
    ]
    every = [*kept, *([holdout] if holdout and isinstance(holdout.log, FlightLog) else [])]
    measured = [log for each in every if isinstance(log := each.log, FlightLog)]
    names = [each.name for each in every]
    if again := distinct(measured, names).notices:
        raise BadInputError(f"{again[0]}; hold out another flight")
    for i, j in recorders(measured):
        raise BadInputError(
            f"two recorders wrote one flight, {names[i]} and {names[j]}, and what both see is one "
            "evidence: reconcile each alone"
        )
    return kept, found.notices


def formula_of(judged: Judged) -> FoundFormula | None:
    """Return the formula of what no effect explains; None where none was found, or none holds."""
    terms = []
    causes = {c.name: c for gap in judged.verdict.gaps if not gap.part for c in gap.causes}
    for found in judged.fitted.gaps:
        name, parameter = effect_and_size(found.member.name)
        if not is_term(found.member.name) or name not in causes:
            continue
        (size,) = [s for s in causes[name].sizes if s.name == parameter] or causes[name].sizes[:1]
        others = [
            effect_and_size(other)
            for other, p in sorted(found.forms.items(), key=lambda item: -item[1])
            if is_term(other) and p > REPORTED_FROM and other != found.member.name
        ]
        terms.append(formula_term(name, size, causes[name].score, others))
    effects = tuple(m.name for m in judged.fitted.members if not is_term(m.name))
    return FoundFormula(tuple(terms), effects) if terms else None


def patch_of(
    judged: Judged, source: str, date: str, reported: Sequence[Gap] | None = None
) -> Patch:
    """Return the patch of an answer: the likeliest cause of each gap, and the terms of a formula.

    `reported` are its gaps, by default those of the verdict. The patch is empty where the names
    were taken back.
    """
    gaps = [gap for gap in (judged.verdict.gaps if reported is None else reported) if gap.causes]
    joined: dict[str, Candidate] = {}
    for gap in gaps:
        first = gap.causes[0]
        old = joined.get(first.name)
        joined[first.name] = (
            first if old is None else replace(old, sizes=(*old.sizes, *first.sizes))
        )
    shapes = {
        signature.effect: signature.shapes
        for each in judged.shown
        for signature in each.block.layout.signatures
        if signature.effect in joined and signature.shapes and signature.effect not in FORMULAS
    }
    others = {gap.causes[0].name: gap.causes[1:] for gap in gaps}
    return patch_of_effects(
        list(joined.values()), source, date, shapes, [others[name] for name in joined]
    )


# By the code of a warning, the parts that explain it: velocities that are late lag behind the
# heading in a turn.
EXPLAINED_BY = {"axes turned": {"GPS receiver and its clock", "attitude and inertial unit"}}


def reported_warnings(logs: Sequence[NamedLog], verdict: Verdict) -> tuple[str, ...]:
    """Return what was said of the logs as they were read.

    The log's name stands before it where there are several. A warning that a named part explains is
    withdrawn: the answer names its cause.
    """
    return tuple(
        text if len(logs) == 1 else Caution(f"{each.name}: {text}", getattr(text, "code", "log"))
        for each in logs
        for text in each.log.header.get("warnings", ())
        if not EXPLAINED_BY.get(getattr(text, "code", ""), set()) & set(verdict.named_parts)
    )


def coefficients_along(
    aircraft: str,
    shown: ShownFlight,
    gaps: Iterable[Gap],
    agreeing: Iterable[tuple[str, Estimate]] = (),
) -> tuple[Coefficient, ...]:
    """Return a model's and the measured coefficients along a flight, by gaps and agreement.

    The gaps change the former, `agreeing` ones show no gap.
    """
    model = shown.block.layout.reference.force_model
    return () if model is None else measured_coefficients(aircraft, model.coarse, gaps, agreeing)


def entries(patch: Patch) -> tuple[EffectSpec, ...]:
    """Return a patch as effects of a case."""
    return tuple(EffectSpec(name_in_case(name), sizes) for name, sizes in patch.entries)


def bounds_of(gaps: Sequence[Gap]) -> dict[str, dict[str, float]]:
    """Return 2σ of the sizes of each gap's first cause, by effect and parameter.

    The units are those of the effects table.
    """
    bounds: dict[str, dict[str, float]] = {}
    for cause in (gap.causes[0] for gap in gaps if gap.causes):
        for size in cause.sizes:
            bounds.setdefault(cause.name, {})[size.name] = float(f"{size.two_sigma:.3g}")
    return bounds
