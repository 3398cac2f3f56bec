"""Run one reconciliation, from the logs to the content of its report, and fly the card again with
its patch.
"""

import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from math import atan2, hypot, pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pitotbench import air
from pitotbench.bench.fleet import require_all, run_tasks
from pitotbench.bench.flights import flown as fly_case
from pitotbench.bench.null_flights import Progress, aircraft_model, as_flown, card_of
from pitotbench.bench.rounds import (
    Looks,
    NamedLog,
    Reconciliation,
    closure_checked,
    first_pass,
    iterate,
    patch_of,
    reconcile_logs,
    settled,
    with_calibrated_probabilities,
)
from pitotbench.effects import OWN_TERMS
from pitotbench.logbook.columns import write_text
from pitotbench.reconciliation.card_comparison import compare_cards, gusts_apart, hand_apart
from pitotbench.reconciliation.formula import closure_on, find_formula, free_sizes_beside
from pitotbench.reconciliation.free_parameters import AnalysisSetting, curve_of
from pitotbench.reconciliation.layout import DAY, Layout, below_range_end, check_log, mean_wind_of
from pitotbench.reconciliation.naming import Naming
from pitotbench.reconciliation.patches import Patch, name_in_case
from pitotbench.reconciliation.pictures import (
    calibration_change,
    clearest_channel,
    gap_map,
    traces,
    waterfall,
)
from pitotbench.reconciliation.renewal import lay_out_with
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.reconciliation.track import track_of
from pitotbench.reconciliation.verdict import for_channels
from pitotbench.records import BadInputError
from pitotbench.records.calibration import Estimate
from pitotbench.records.case import PILOTS, Case, EffectSpec, PressureErrorSpec, Wind, rates_for
from pitotbench.records.gap import Account, FlownAgain, FoundFormula
from pitotbench.records.log import FlightLog, Provenance
from pitotbench.records.outputs import PAGES, require_file
from pitotbench.records.verdict import SURE, Candidate, JoinedFlight, Verdict

if TYPE_CHECKING:
    from pandas import DataFrame

HOLD_OUT_LEAST = (
    0.5  # closure of a held-out log below which a formula is shown, but not put into the model
)


@dataclass(frozen=True, slots=True)
class BeyondTable:
    """The passes of a reconciliation, with the formula of what they leave; None where nothing is
    left to describe.

    Where a formula alone says more than names with a formula beside them, the names are withdrawn.
    `free_sizes` are the free parameters of the log beside the formula, by name.
    """

    looks: Looks
    formula: FoundFormula | None = None
    free_sizes: Mapping[str, float] = field(default_factory=dict)

    @property
    def entries(self) -> tuple[Candidate, ...]:
        """The formula as effects for the patch; empty where it is refused."""
        if self.formula is None or self.formula.refused:
            return ()
        sizes: dict[str, list[Estimate]] = {}
        for term in self.formula.terms:
            sizes.setdefault(term.effect, []).append(term.size)
        return tuple(Candidate(name, tuple(each), 0.0) for name, each in sizes.items())


def beyond_the_table(
    aircraft: str, looks: Looks, holdout: FlightLog | None, progress: Progress | None = None
) -> BeyondTable:
    """Describe what the named effects leave of the gap; `holdout` is a log on which the formula is
    to hold as well.

    Raises BadInputError for a held-out log that cannot be compared.
    """
    first = looks.first
    if not looks.remains:
        return BeyondTable(looks)
    if progress is not None:
        progress("looking for a formula of what the table does not explain")
    names = dict(patch_of(looks, (), "", "").entries)
    formula = find_formula(_remaining(looks), first.null)
    # A model whose own terms are off in many places is not one missing effect that a formula
    # describes better.
    if set(names) - OWN_TERMS and len(OWN_TERMS & set(names)) <= THRESHOLDS.effects_most:
        alone = find_formula(first.naming.layout, first.null)
        if alone is not None and _is_simpler(alone, formula, names):
            why = f"a formula explains more than {', '.join(names)} with a formula beside it"
            first = replace(first, checks=replace(first.checks, formula=why))
            looks, formula, names = first_pass(first), alone, {}
    if formula is None:
        return BeyondTable(looks)
    formula = replace(formula, beside=tuple(names))
    free = free_sizes_beside(_remaining(looks), first.null, formula)
    if holdout is not None:
        layout = lay_out_with(holdout, aircraft_model(aircraft), first.layout.setting, names)
        closed = closure_on(layout, for_channels(first.null, layout), formula)
        why = f"it closes only {closed.share:.0%} of the gap of the held-out log"
        formula = replace(
            formula, closure_holdout=closed, refused=why if closed.share < HOLD_OUT_LEAST else ""
        )
    return BeyondTable(looks, formula, free)


def _remaining(looks: Looks) -> Layout:
    """The layout of the last look, with what it named subtracted."""
    naming = looks.last
    if looks.rounds[-1].verdict.kind not in SURE:
        return naming.layout
    columns = [naming.layout.signatures[c].column for c in naming.fit.columns]
    return naming.layout.without(columns, naming.fit.sizes)


def _is_simpler(
    alone: FoundFormula, beside: FoundFormula | None, names: Mapping[str, Mapping[str, float]]
) -> bool:
    """Whether a formula alone leaves no more of the gap than names with a formula, and has fewer
    sizes.
    """
    if beside is None:
        return False
    sizes = sum(map(len, names.values())) + len(beside.terms)
    return len(alone.terms) < sizes and alone.closure.after <= beside.closure.after


@dataclass(frozen=True, slots=True)
class FullReconciliation:
    """The reconciliation of one or several logs, its account for a report, and its patch.

    It shows itself in a notebook as its account does: in words, as a picture and as a table of the
    causes.
    `provenance`: the files and the choices behind the answer, where who asked for it told them.
    """

    reconciliation: Reconciliation
    account: Account
    patch: Patch
    provenance: Provenance = field(default_factory=Provenance)

    @property
    def verdict(self) -> Verdict:
        """The answer."""
        return self.account.rounds[0].verdict

    @property
    def probabilities(self) -> Mapping[str, float]:
        """The probability of each cause, given a gap."""
        return self.verdict.probabilities

    @property
    def sizes(self) -> Mapping[str, tuple[Estimate, ...]]:
        """The sizes of the named effects, each with its 2σ, in the units of the effects table."""
        return {effect.name: effect.sizes for effect in self.verdict.effects}

    @property
    def flights(self) -> tuple[JoinedFlight, ...]:
        """What each flight says."""
        return self.account.flights

    def write_page(self, path: str | Path) -> None:
        """Write the report as a page (.html). Raises BadInputError for another name."""
        from pitotbench.show.gap_page import account_page

        require_file(Path(path), PAGES)
        write_text(Path(path), account_page(self.account))

    def write_record(self, path: str | Path) -> None:
        """Write the record for the file (.html), as `reconcile --record` does. Raises as
        `write_page`.
        """
        from pitotbench.show.gap_page import reconciliation_record

        require_file(Path(path), PAGES)
        write_text(Path(path), reconciliation_record(self.account, self.provenance))

    def to_frame(self) -> "DataFrame":
        """Return the causes as a table, the most probable first."""
        return self.account.to_frame()

    def plot(self, axes: Any = None) -> Any:
        """Draw the probabilities of the causes on matplotlib's axes, or in a new figure; return the
        figure.
        """
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
    refly_holdout: bool = True,
    keep: bool = True,
) -> FullReconciliation:
    """Reconcile logs, judge them again until nothing significant remains, and fly a card again.

    `card` is that of all logs that state none of their own. With `refly` the card of the log with
    the largest gap is flown again, with `refly_holdout` that of the held-out log as well. Without
    `keep` the cache of null flights is neither read nor written. Raises BadInputError for a log
    that cannot be used.
    """
    say = progress or (lambda text: None)
    several = [measured] if isinstance(measured, NamedLog) else measured
    logs = [replace(each, card=each.card or card) for each in several]
    other = holdout.log if holdout else None
    first = reconcile_logs(logs, aircraft, other, progress=progress, setting=setting, keep=keep)
    looks = closure_checked(settled(aircraft, iterate(aircraft, first, progress), other))
    source = ", ".join(each.name for each in logs)
    beyond = beyond_the_table(aircraft, looks, other, progress)
    looks = with_calibrated_probabilities(beyond.looks)
    first = looks.first
    patch = patch_of(looks, beyond.entries, source, datetime.now(UTC).strftime("%Y-%m-%d"))
    effects = entries(patch)
    refly, refly_holdout = refly and aircraft != "none", refly_holdout and aircraft != "none"
    why = "no aircraft model to fly it with" if aircraft == "none" else "not asked for"
    flown, flown_holdout = FlownAgain(skipped=why), FlownAgain(skipped=why)
    shown = as_the_log_shows(first.card, first.naming, beyond.free_sizes) if refly else None
    if refly:
        say("flying the card again")
        flown = fly_again(first.logs[first.shown].log, shown, effects)
    if refly and refly_holdout and holdout is not None:
        say("flying the card of the held-out log again")
        again = holdout.card or card or card_of(holdout.log.header, aircraft)
        if again is not None:
            again = as_flown(again, holdout.log)
            again = again if shown is None else replace(again, pressure_error=shown.pressure_error)
        flown_holdout = fly_again(holdout.log, again, effects)
    pictured, rounds = looks.pictured, looks.told
    over_time = traces(pictured)
    account = Account(
        log=source,
        aircraft=aircraft,
        holdout=holdout.name if holdout else "",
        rounds=rounds,
        gap_map=gap_map(pictured, first.null),
        waterfall=waterfall(pictured),
        traces=over_time,
        patch=patch.text,
        effects=looks.effects,
        flown=flown,
        flown_holdout=flown_holdout,
        null_flights=first.null.flights,
        formula=beyond.formula,
        flights=first.flights,
        telling=clearest_channel(pictured, first.null, over_time),
        calibration=calibration_change(pictured),
        warnings=told_warnings([*logs, *([holdout] if holdout else [])], rounds[0].verdict),
    )
    return FullReconciliation(first, account, patch)


# By the code of a warning, the parts that explain it: velocities that are late lag behind the
# heading in a turn.
EXPLAINED_BY = {"axes turned": {"GPS receiver and its clock", "attitude and vanes"}}


def told_warnings(logs: Sequence[NamedLog], verdict: Verdict) -> tuple[str, ...]:
    """Return what was said of the logs as they were read, with the log's name where there are
    several.

    A warning that a named part explains is withdrawn: the answer tells its cause.
    """
    return tuple(
        text if len(logs) == 1 else f"{each.name}: {text}"
        for each in logs
        for text in each.log.header.get("warnings", ())
        if not EXPLAINED_BY.get(getattr(text, "code", ""), set()) & set(verdict.named_parts)
    )


def entries(patch: Patch) -> tuple[EffectSpec, ...]:
    """Return a patch as effects of a case."""
    return tuple(EffectSpec(name_in_case(name), sizes) for name, sizes in patch.entries)


# Fly the card of a log again in the simulator, without and with the patch.

OTHER_HAND = (
    0.3  # apart from which another pilot is tried: two flights by one hand are some 0.15 apart
)
SAME_GUSTS = (
    0.25  # apart, in the logarithm, below which other gusts are no reason for another motion
)
FLIGHTS = 3  # of each airplane, unpatched and patched, so that the differences between flights show chance
# The free parameters of the temperature, where no header tells it: by its effect on the airplane,
# and as measured
WARMER, MEASURED_WARMER = f"{DAY} warmer_k", "temperature offset"
CURVE_POINTS = 96  # of the error curve: lines between them are within 0.01 kt of it, for errors of up to 0.15 q_c
SEED = 760_001  # truth and sensor seeds count up from here


def fly_again(log: FlightLog, card: Case | None, effects: Sequence[EffectSpec]) -> FlownAgain:
    """Compare a log with its card as the simulator flies it, in the wind of the log, without and
    with effects.

    Where the airplane of the log moves to and fro as under another hand than that of the card, in
    gusts of the same strength, the card is flown by the pilot whose hand is nearest. Returns only a
    reason where there is no card, or where it cannot be flown.
    """
    if card is None:
        return FlownAgain(
            skipped="no card: the header of the log holds none and --card was not given"
        )
    if log.segment is None:
        return FlownAgain(
            skipped="the log has no column `segment`: its parts cannot be matched to those of the "
            "card"
        )
    slow = rates_for(card.das.air_rate)[
        0
    ]  # means of segments are compared, and the slowest rate gives them too
    base = replace(card, wind=wind_of_log(log), effects=(), integration_rate=slow)
    try:
        found = _flights([base], effects)
    except BadInputError as error:
        return FlownAgain(skipped=f"the card cannot be flown: {error}")
    pilot, (_, after) = base.pilot, found[base.pilot]
    if hand_apart(log, after) > OTHER_HAND and gusts_apart(log, after) < SAME_GUSTS:
        with suppress(BadInputError):  # a card may be too hard for another pilot
            found |= _flights([replace(base, pilot=p) for p in PILOTS if p != base.pilot], effects)
        pilot = min(found, key=lambda p: hand_apart(log, found[p][1]))
    compared = compare_cards(log, *found[pilot])
    return compared if pilot == base.pilot else replace(compared, pilot=pilot)


def _flights(
    cards: Sequence[Case], effects: Sequence[EffectSpec]
) -> dict[str, tuple[list[FlightLog], list[FlightLog]]]:
    """Flights of some cards by their pilots, without and with effects."""
    numbers = range(SEED, SEED + FLIGHTS)
    plain = [replace(card, truth_seed=n, sensor_seed=n) for card in cards for n in numbers]
    patched = [replace(case, effects=tuple(effects)) for case in plain] if effects else []
    # Processes of their own take as long to load as these flights take; those of other pilots are
    # more.
    jobs = min(os.cpu_count() or 1, FLIGHTS) if len(cards) > 1 else 1
    logs = require_all(run_tasks(fly_case, [*plain, *patched], jobs))
    before, after = logs[: len(plain)], logs[len(plain) :] or logs
    parts = [slice(i * FLIGHTS, (i + 1) * FLIGHTS) for i in range(len(cards))]
    return {
        card.pilot: (before[part], after[part]) for card, part in zip(cards, parts, strict=True)
    }


def as_the_log_shows(
    card: Case | None, naming: Naming, beside_formula: Mapping[str, float] | None = None
) -> Case | None:
    """Return a card with the error curve of a log and, where its header does not tell the day, in
    its temperature.

    The free parameters beside the named effects tell how much warmer the air is than the card says.
    Where a formula takes a part of the gap, `beside_formula` holds them as they are beside it.
    """
    if card is None:
        return card
    layout = naming.layout
    sizes = dict(
        zip(layout.free.names, naming.equations.free_sizes(naming.fit.columns), strict=True)
    )
    sizes |= beside_formula or {}
    card = replace(card, pressure_error=error_curve_of(layout, sizes))
    if WARMER not in sizes:
        return card
    # A card counts from the standard day at its geometric height, a log from that at its pressure
    # height. In warmer air a pressure lies higher, where the standard day is cooler.
    height = air.pressure_altitude(layout.scene.clean["static_pressure"])
    steeper = air.SEA_LEVEL_TEMPERATURE / float(np.mean(air.standard_temperature(height)))
    measured = sizes.get(MEASURED_WARMER, 0.0)  # a log may lack the thermometer
    return replace(
        card, temperature_offset=card.temperature_offset + sizes[WARMER] + steeper * measured
    )


def error_curve_of(layout: Layout, sizes: Mapping[str, float]) -> PressureErrorSpec:
    """Return the error curve that a log shows, with `sizes` of its free parameters.

    It reaches over the airspeeds of the log as they are after correction, and is constant beyond
    them.
    """
    shown = layout.scene.clean["impact_pressure"][layout.measured]
    indicated = np.linspace(float(shown.min()), float(shown.max()), CURVE_POINTS)
    share = curve_of(indicated, (*layout.curves, sizes))
    location = "static" if layout.setting.static_error else "impact"
    speeds = air.calibrated_airspeed(indicated).tolist()
    return PressureErrorSpec(
        "table", airspeed=tuple(speeds), values=tuple(share.tolist()), location=location
    )


def wind_of_log(log: FlightLog) -> Wind:
    """Return the mean wind of a log: ground velocity less velocity through the air."""
    track = track_of(log, check_log(log).fresh)
    north, east, _ = mean_wind_of(track, below_range_end(track, log))
    return Wind(hypot(north, east), (atan2(-east, -north)) % (2.0 * pi), 0.0)
