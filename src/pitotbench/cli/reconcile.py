"""`pitotbench reconcile`: judge a measured log; print a verdict, write a report and a patch."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pitotbench.cli.shared_flags import (
    asked_flags,
    flag,
    read_logs,
    require_page,
    say,
    shared,
    stated_facts,
    stated_part,
    stated_request,
    tell,
)
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration_request import Reading

if TYPE_CHECKING:
    from pitotbench.bench.workflow import FullReconciliation
    from pitotbench.records.log import FlightLog, Provenance
    from pitotbench.records.maneuver import Maneuvers


FLAGS = (
    flag(
        "log",
        type=Path,
        nargs="+",
        metavar="MEASURED",
        help="measured log (.csv, .parquet, .mat), or several of one airplane: causes and sizes "
        "are shared",
    ),
    flag(
        "--aircraft",
        default="navajo",
        help="aircraft model, or none: sensors alone (default: %(default)s)",
    ),
    flag(
        "--holdout", type=Path, metavar="LOG", help="another log, on which the gap is to shrink too"
    ),
    *asked_flags(Reading),
    *shared("record", "units", "json"),
    flag(
        "--card",
        type=Path,
        metavar="CASE",
        action="append",
        help="case file that says what was flown (default: the log's header); give it once, or "
        "once for each log",
    ),
    flag(
        "--no-next-flight",
        action="store_true",
        help="without effect; accepted for scripts of earlier versions",
    ),
    flag(
        "--terms",
        action="store_true",
        help="let all aerodynamic terms of the model's file compete; a log without a card is then "
        "judged by its maneuvers (default: for logs of system identification, such as SIDPAC's "
        "fdata)",
    ),
    flag(
        "--apply",
        metavar="NAME",
        help="keep the aircraft with what is named as ./aircraft/<aircraft>+NAME",
    ),
    flag(
        "--close",
        metavar="NAME",
        help="patch what is named into ./aircraft/<aircraft>+NAME, judge the log again with it, and "
        "so on until nothing more closes",
    ),
    flag(
        "--choose",
        metavar="CAUSE",
        default="",
        help="patch this cause of a set that the log does not tell apart",
    ),
    flag(
        "--no-cache",
        action="store_true",
        help="fly the null flights of the card anew, and do not keep them",
    ),
    flag("-v", "--verbose", action="store_true", help="print the candidates and all checks"),
    flag(
        "--out", type=Path, help="folder for report.html, verdict.json, patch.toml and overlay.xml"
    ),
)


def run(options: argparse.Namespace) -> int:
    """Reconcile a log, print the verdict, and write its report and its patch."""
    from pitotbench.bench.verdict_folder import install, keep
    from pitotbench.show.reader_units import reader_units
    from pitotbench.show.verdict import account_json
    from pitotbench.show.verdict_tree import account_tree

    _check_variant(options)
    _check_folder(options)
    reader_units(options.units)  # a wrong word is refused before minutes of work
    outcome = _outcome(options)
    document = account_json(outcome.account)
    written = keep(outcome, document, options.out, options.units) if options.out is not None else []
    if options.record is not None:
        outcome.write_record(options.record, options.units)
    tell(options, lambda: document, lambda: account_tree(outcome.account))
    for line in [*written, *(install(outcome, options.apply) if options.apply else ())]:
        say(line)
    closing = outcome.account.closing
    if closing is not None and closing.not_told and not closing.closed:
        raise NoAnswerError(closing.not_told)
    return 0


def _maneuvers(
    options: argparse.Namespace, path: Path, log: "FlightLog | None"
) -> "Maneuvers | None":
    """Return the maneuvers of a file that stand for a log, None where there are none.

    A file of system identification has some, and with --terms a log that states no card.
    """
    from pitotbench.models.maneuver_model import in_place_of_log
    from pitotbench.models.maneuver_parts import maneuvers_of
    from pitotbench.models.sidpac import read_identification

    if log is None:
        found = [read_identification(path)]
    elif options.terms and not options.card and "case" not in log.header:
        found = maneuvers_of(log, path.stem)
    else:
        return None
    if options.aircraft == "none":
        raise BadInputError("--aircraft none has no aerodynamic terms: name the aircraft")
    return in_place_of_log(found, options.aircraft)


def _check_variant(options: argparse.Namespace) -> None:
    """Refuse a name that cannot be used, before the log takes minutes to reconcile."""
    from pitotbench.simulation.modified import require_free

    names = [name for name in (options.apply, options.close) if name is not None]
    if len(names) > 1:
        raise BadInputError("--apply and --close both write the patched aircraft: give one of them")
    for name in names:
        require_free(options.aircraft, name)


def _check_folder(options: argparse.Namespace) -> None:
    """Refuse a folder or a record that cannot be written, or that would replace an input."""
    from pitotbench.bench.verdict_folder import WRITTEN
    from pitotbench.records.outputs import require_folder

    mapping = Path(options.mapping) if options.mapping else None
    every = [*options.log, options.holdout, *(options.card or ()), mapping]
    inputs = [path for path in every if path is not None]
    if options.out is not None:
        require_folder(options.out, WRITTEN, inputs)
    require_page(options.record, inputs)


def _outcome(options: argparse.Namespace) -> "FullReconciliation":
    from pitotbench.bench.questions import reconcile
    from pitotbench.bench.workflow import NamedLog
    from pitotbench.models.sidpac import is_identification
    from pitotbench.records.case_file import read_case

    cards = [read_case(path) for path in options.card or ()]
    if len(cards) not in (0, 1, len(options.log)):
        raise BadInputError(
            f"{len(cards)} cards for {len(options.log)} logs: give --card once, or once for each "
            "log"
        )
    own = cards if len(cards) > 1 else [None] * len(options.log)
    holdouts = [options.holdout] if options.holdout else []
    paths = [*options.log, *holdouts]
    arrays = [path for path in paths if is_identification(path)]
    others = [path for path in paths if path not in arrays]
    read = (
        read_logs(others, options.mapping, part=stated_part(options), facts=stated_facts(options))
        if others
        else []
    )
    logs = dict(zip(others, read, strict=True))
    named = [
        NamedLog(path.name, _maneuvers(options, path, logs.get(path)) or logs[path], card)
        for path, card in zip(paths, [*own, *(None for _ in holdouts)], strict=True)
    ]
    # Only these show the card flown again.
    refly = options.out is not None or options.json or options.record is not None
    outcome = reconcile(
        named[: len(options.log)],
        options.aircraft,
        named[-1] if holdouts else None,
        cards[0] if len(cards) == 1 else None,
        refly=refly,
        progress=say,
        mapping=options.mapping,
        keep=not options.no_cache,
        close=options.close,
        terms=options.terms,
        choose=options.choose.replace(" ", "_"),
    )
    if not options.record:
        return outcome
    return replace(outcome, provenance=_provenance(options, [logs.get(path) for path in paths]))


def _provenance(options: argparse.Namespace, logs: "list[FlightLog | None]") -> "Provenance":
    """Return the files and the choices behind the verdict."""
    from pitotbench.bench.calibration_request import choices_made, mapping_sources
    from pitotbench.bench.calibrations import (
        advice_of,
        flag_choice,
        model_sources,
        provenance_of,
        setting_of,
        sources_of,
    )
    from pitotbench.records.log import Choice

    asked = stated_request(options, Reading)
    count = len(options.log)
    sources = [
        *sources_of("log", options.log, logs[:count]),
        *sources_of("held-out log", [options.holdout] * len(logs[count:]), logs[count:]),
        *(("card", path, None) for path in options.card or ()),
        *mapping_sources(asked),
        *model_sources(options.aircraft),
    ]
    setting = setting_of(advised := advice_of([each for each in logs if each], options.mapping))
    place = "static source" if setting.static_error else "impact pressure"
    choices = [
        flag_choice("aircraft", options.aircraft, ""),
        *choices_made(asked),
        Choice("place of the error curve", place, "mapping" if setting.static_error else "default"),
        Choice(
            "mach max", f"{setting.mach_max:g}", "mapping" if "mach_max" in advised else "default"
        ),
    ]
    return provenance_of(sources, choices)
