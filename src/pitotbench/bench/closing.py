"""Close the loop: patch the airplane, judge its logs again with the patch, and tell what is left."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from datetime import UTC, datetime

from pitotbench.bench.fleet import progress as progress_bar
from pitotbench.bench.model_comparison import coefficient
from pitotbench.bench.null_flights import COARSE_RATE, Progress, aircraft_model
from pitotbench.bench.workflow import (
    FullReconciliation,
    JudgedLog,
    as_the_log_shows,
    bounds_of,
    entries,
    fly_again,
    patch_of,
)
from pitotbench.effects import effect_of
from pitotbench.effects.effect import AircraftEffect
from pitotbench.effects.stability import CHANGE
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.patches import Patch
from pitotbench.reconciliation.regression import Fitted
from pitotbench.reconciliation.term_regression import terms_of
from pitotbench.reconciliation.verdict import Judged, ShownFlight, for_channels, hold_out, judge
from pitotbench.records import BadInputError
from pitotbench.records.calibration import Estimate
from pitotbench.records.gap import Closing
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import Candidate, Closure, Gap
from pitotbench.simulation.aircraft import find_aircraft, read_baseline
from pitotbench.simulation.force_meter import measure_forces
from pitotbench.simulation.modified import install_variant, require_free
from pitotbench.simulation.plant import Plant

# Each round patches what the last judgment found of the airplane, and judges the same logs again:
# with the forces of the patched airplane, the floor of the first null flights, and the errors of
# the patched sizes in it. What sensors and the air do is no airplane's: each judgment takes it out
# of the log anew.

ROUNDS = 5
LEAST_GROWTH = 0.01  # of the explainable gap, held out: below it a round is not worth a patch


def require_closable(aircraft: str, name: str) -> None:
    """Raise BadInputError where no airplane of a name can be written: without a model, or where the
    name is taken.
    """
    if aircraft == "none":
        raise BadInputError(
            "--close patches an airplane, and --aircraft none has none: name the aircraft"
        )
    require_free(aircraft, name)


def close_loop(
    found: FullReconciliation,
    name: str,
    holdout: FlightLog | None = None,
    progress: Progress | None = None,
    refly: bool = True,
) -> FullReconciliation:
    """Patch the airplane of a reconciliation until nothing more closes held out.

    `<aircraft>+<name>` is written whole at the end of each round. `holdout` is the held-out log of
    the reconciliation. With `refly` the card of the log with the largest gap is flown again, without
    and with all that was found. Returns the reconciliation with its `closing`, and with the patch of
    all rounds. Raises BadInputError where the name is taken.
    """
    aircraft, logs, judged = found.account.aircraft, found.logs, found.judged
    require_closable(aircraft, name)
    say = progress or (lambda text: None)
    first, patched, closed = judged, dict[str, Gap](), list[float]()
    held, unheld = judged.verdict.closure_holdout, None
    with progress_bar("rounds of closing" if progress else "", ROUNDS) as step:
        for number in range(1, ROUNDS + 1):
            new = [gap for gap in _shares(judged, first) if _is_lasting(gap)]
            growth = sum(gap.closes_held_out for gap in new)
            if growth < LEAST_GROWTH:
                break
            patched, closed = (
                _joined([*patched.values(), *new]),
                [*closed, sum([*closed[-1:], growth])],
            )
            patch = _patch(found, judged, list(patched.values()))
            _write(found, name, patch, list(patched.values()), closed[-1])
            unheld = judged.verdict.closure_holdout
            say(f"round {number}: judging again with {aircraft}+{name}")
            logs, judged = _judged_again(logs, f"{aircraft}+{name}", holdout)
            step()
    told = [gap for gap in _shares(judged, first) if gap.causes]
    every = [*patched.values(), *(gap for gap in told if not _is_lasting(gap))]
    patch = _patch(found, judged, every)
    main = _main(first)
    of_main = found.logs[first.shown.index(main)]
    account = replace(
        found.account,
        patch=patch.text,
        entries=patch.entries,
        closing=Closing(
            f"{aircraft}+{name}",
            tuple(closed),
            tuple(patched.values()),
            tuple(told),
            _coefficients(aircraft, main, patched),
            judged.verdict,
            Closure(held.before, unheld.after, held.noise).share if held and unheld else None,
        ),
    )
    if refly:
        say("flying the card again")
        card = as_the_log_shows(of_main.card, main)
        account = replace(account, flown=fly_again(of_main.log, card, entries(patch)))
    return replace(found, account=account, patch=patch)


def _is_lasting(gap: Gap) -> bool:
    """Whether a gap is one of the airplane itself, for the whole flight."""
    effect = effect_of(gap.causes[0].name) if gap.causes else None
    return isinstance(effect, AircraftEffect) and not effect.part_of


def _main(judged: Judged) -> ShownFlight:
    """The flight with the largest gap."""
    return max(judged.shown, key=lambda each: each.closure.before - each.closure.noise)


def _shares(judged: Judged, first: Judged) -> list[Gap]:
    """The gaps of an answer, with what they close as shares of the first explainable gap."""
    now, whole = (
        max(1.0, main.closure.before - main.closure.noise) for main in (_main(judged), _main(first))
    )
    part = now / whole
    return [
        replace(gap, closes=part * gap.closes, closes_held_out=part * gap.closes_held_out)
        for gap in judged.verdict.gaps
    ]


def _joined(gaps: Iterable[Gap]) -> dict[str, Gap]:
    """Gaps by their first cause; what a later round finds of one adds to its sizes."""
    joined: dict[str, Gap] = {}
    for gap in gaps:
        name = gap.causes[0].name
        old = joined.get(name)
        joined[name] = (
            gap
            if old is None
            else replace(
                gap,
                causes=(_added(old.causes[0], gap.causes[0]), *gap.causes[1:]),
                closes=old.closes + gap.closes,
                closes_held_out=old.closes_held_out + gap.closes_held_out,
            )
        )
    return joined


def _added(old: Candidate, new: Candidate) -> Candidate:
    """A cause with the sizes of two rounds; the later bound is that of the sum."""
    sizes = {size.name: size for size in old.sizes}
    for size in new.sizes:
        before = sizes[size.name].value if size.name in sizes else 0.0
        sizes[size.name] = Estimate(size.name, before + size.value, size.two_sigma)
    return replace(new, sizes=tuple(sizes.values()), probability=old.probability, score=old.score)


def _patch(found: FullReconciliation, judged: Judged, gaps: Sequence[Gap]) -> Patch:
    date = datetime.now(UTC).strftime("%Y-%m-%d")
    return patch_of(judged, found.account.log, date, gaps)


def _write(
    found: FullReconciliation, name: str, patch: Patch, gaps: Sequence[Gap], closed: float
) -> None:
    """Write the patched airplane in the place of that of the round before."""
    provenance = {
        "log": found.account.log,
        "closed_held_out": round(closed, 3),
        "two_sigma": bounds_of(gaps),
    }
    install_variant(found.account.aircraft, name, entries(patch), provenance, anew=True)


def _judged_again(
    logs: Sequence[JudgedLog], aircraft: str, holdout: FlightLog | None
) -> tuple[tuple[JudgedLog, ...], Judged]:
    """Judge logs with another airplane and the same floor; without null flights it is the log's
    own, which is lower where less is left.
    """
    model = aircraft_model(aircraft)
    again = []
    for each in logs:
        layout = lay_out(each.log, model, each.layout.setting)
        floor = for_channels(each.null if each.null.flights else None, layout)
        again.append(replace(each, layout=layout, null=floor))

    def held_out(fitted: Fitted) -> Closure | None:
        assert holdout is not None
        return hold_out(holdout, model, again[0].null, fitted, again[0].layout.setting)

    judged = judge(
        [each.name for each in again],
        [each.layout for each in again],
        [each.null for each in again],
        [each.card.maneuver if each.card else "" for each in again],
        None if holdout is None else held_out,
    )
    return tuple(again), judged


def _coefficients(
    aircraft: str, main: ShownFlight, names: Iterable[str]
) -> dict[str, tuple[float, str]]:
    """The coefficients of the unchanged model along a log, of the effects that are terms of its
    file.
    """
    baseline, model = read_baseline(find_aircraft(aircraft)), main.block.layout.scene.force_model
    own = [n for n in names if any(p.name == CHANGE for p in effect_of(n).parameters)]
    if model is None or not own:
        return {}
    plant = Plant.load(aircraft, COARSE_RATE, at_once=True)
    forces = measure_forces(plant, model.coarse, [f.name for f in baseline.functions if f.name])
    found: dict[str, tuple[float, str]] = {}
    for name in own:
        effect = effect_of(name)
        assert isinstance(effect, AircraftEffect)
        overlay = effect.overlay({CHANGE: 1.0}, baseline)
        read = " ".join(
            [*(f">{s.function}<" for s in overlay.scalings), *(f.value for f in overlay.functions)]
        )
        terms = [term for term in terms_of(baseline) if f">{term.function.name}<" in read]
        each = [coefficient(term, forces, model.coarse) for term in terms]
        if each:
            found[name] = (sum(value or 0.0 for value, _ in each), each[0][1])
    return found
