"""The command line: parse, one call to the bench, print. Slow packages load only where needed."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from pitotbench.catalog import UnknownNameError
from pitotbench.fixed_speed_command import add_fixed_speed
from pitotbench.planner.command import add_flags
from pitotbench.records.errors import BadInputError, NoAnswerError

if TYPE_CHECKING:
    from pitotbench.bench_reconcile import Setting
    from pitotbench.calibrate.options import CalibrationOptions
    from pitotbench.records.calibration import Calibration
    from pitotbench.records.fixed_speed import FixedSpeedPoint
    from pitotbench.records.log import FlightLog

DONE, BAD_INPUT, NO_ANSWER = 0, 2, 3


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit code: 0 done, 2 bad input, 3 not converged or not observable."""
    return guarded(_parser().parse_args(arguments))


class OneLineParser(argparse.ArgumentParser):
    """A parser whose refusals are one line, like every other error of the command line."""

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")


def guarded(options: argparse.Namespace) -> int:
    """Run the parsed command; a refusal becomes one line on standard error and an exit code."""
    try:
        return int(options.run(options))
    except (BadInputError, UnknownNameError) as error:
        return _refuse(error, BAD_INPUT)
    except OSError as error:
        return _refuse(BadInputError(f"{error.filename or 'file'}: {error.strerror or error}"), BAD_INPUT)
    except NoAnswerError as error:
        return _refuse(error, NO_ANSWER)


def _refuse(error: Exception, code: int) -> int:
    print(f"pitotbench: {error}", file=sys.stderr)
    return code


def _parser() -> argparse.ArgumentParser:
    parser = OneLineParser(
        prog="pitotbench", description="A simulated flight-test bench for pitot-static calibration."
    )
    commands = parser.add_subparsers(required=True, metavar="command")
    _add_fly(commands.add_parser("fly", help="fly a case file and write the log"))
    _add_calibrate(commands.add_parser("calibrate", help="recover the error curve and the wind from a log"))
    add_fixed_speed(commands.add_parser("fixed-speed", help="leg and turn GPS methods, of a log or of typed legs"))
    add_campaign(commands.add_parser("campaign", help="fly maneuvers, sense and calibrate them"))
    add_reconcile(commands.add_parser("reconcile", help="name the effect that a simulation lacks"))
    add_flags(commands.add_parser("plan", help="what to fly: the 2σ of every maneuver, before it is flown"))
    return parser


def _add_fly(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("case", type=Path, help="case file (TOML)")
    parser.add_argument("-o", "--out", type=Path, required=True, help="log to write: .csv, .parquet or .mat")
    parser.add_argument("--truth", action="store_true", help="also write <name>.truth.parquet beside the log")
    parser.set_defaults(run=_fly)


def _fly(options: argparse.Namespace) -> int:
    from pitotbench.bench import fly_to_log
    from pitotbench.records.case_file import read_case

    log = fly_to_log(read_case(options.case), options.out, options.truth)
    print(f"{len(log):,} rows written to {options.out}")
    return DONE


def _add_calibrate(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("logs", nargs="+", type=Path, metavar="LOG", help="log file (.csv, .parquet, .mat)")
    parser.add_argument("--model", help="pressure-error model, or auto (default: the mapping's, else inverse+)")
    parser.add_argument("--mapping", help="how to read a foreign log: a shipped name or a TOML file")
    parser.add_argument("--mach-max", type=float, help="leave out rows above this Mach number")
    parser.add_argument("--ground-speed-min-kt", type=float, help="leave out rows below this ground speed [kt]")
    parser.add_argument("--on-condition", action="store_true", help="use only rows flagged on condition")
    parser.add_argument("--no-down", action="store_true", help="do not use the vertical GPS velocity")
    parser.add_argument("--method", help="covering or paper (default: covering)")
    parser.add_argument(
        "--error-location",
        help="impact (as published) or static (static source) (default: the mapping's, else impact)",
    )
    parser.add_argument("--wind", help="constant, linear (in time and height) or drifting (default: constant)")
    parser.add_argument(
        "--latency",
        help="seconds by which GPS velocity trails the air data, `estimated`, or `checked` (default)",
    )
    parser.add_argument("--accuracy", help="2σ of constant errors, such as temperature_k=1,static_pressure_pa=40")
    parser.add_argument("--all-rows", action="store_true", help="keep faulty rows")
    parser.add_argument(
        "--separately", action="store_true", help="a curve for each of several logs, not one for all"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document (a list for several logs)")
    parser.add_argument("--report", type=Path, help="also write a page (HTML)")
    parser.set_defaults(run=_calibrate)


def _calibrate(options: argparse.Namespace) -> int:
    from pitotbench.bench import calibrate, calibrate_together, cross_check
    from pitotbench.logbook import read_log
    from pitotbench.show.fixed_speed import points_json, print_points
    from pitotbench.show.tables import calibration_json, print_calibration

    choice = _choice(options)
    logs = [(path, read_log(path, options.mapping)) for path in options.logs]
    if options.separately or len(logs) == 1:
        found = [calibrate(log, choice) for _, log in logs]
    else:
        found = list(calibrate_together([log for _, log in logs], choice))
    results = [(path, log, result) for (path, log), result in zip(logs, found, strict=True)]
    points = [cross_check(log, choice) for _, log in logs]
    if options.report:
        _write_report(options.report, results, points)
    if options.json:
        pairs = zip(found, points, strict=True)
        documents = [calibration_json(result) | {"fixed_speed": points_json(beside)} for result, beside in pairs]
        print(json.dumps(documents[0] if len(documents) == 1 else documents, indent=1))
        return DONE
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True)
    for (path, _, result), beside in zip(results, points, strict=True):
        console.print(f"[bold]{path.name}[/bold]")
        print_calibration(result, console)
        print_points(beside, console, result.curve)
    return DONE


_CHOICES = ("model", "method", "error_location", "mach_max", "wind")
_NAMED_LATENCIES = ("checked", "estimated")


def _choice(options: argparse.Namespace) -> "CalibrationOptions":
    """What the user states, before what the mapping advises, before the defaults."""
    from pitotbench.calibrate.accuracy import parse_accuracies
    from pitotbench.calibrate.options import options_from
    from pitotbench.logbook import find_mapping
    from pitotbench.units import KNOT

    advised = find_mapping(options.mapping).calibrate if options.mapping else {}
    stated = {name: getattr(options, name) for name in _CHOICES if getattr(options, name) is not None}
    if options.ground_speed_min_kt is not None:
        stated["ground_speed_min"] = options.ground_speed_min_kt * KNOT
    if options.no_down:
        stated["use_down"] = False
    if options.on_condition:
        stated["on_condition"] = True
    if options.all_rows:
        stated["robust"] = False
    if options.accuracy is not None:
        stated["accuracies"] = parse_accuracies(options.accuracy)
    if options.latency is not None:
        stated |= _latency(options.latency)
    return options_from({"latency": "checked", **advised, **stated})


def _latency(text: str) -> dict[str, object]:
    if text in _NAMED_LATENCIES:
        return {"latency": text}
    try:
        return {"gps_latency": float(text), "latency": "checked"}
    except ValueError as error:
        raise BadInputError(f"--latency {text!r}: give seconds, or {' or '.join(_NAMED_LATENCIES)}") from error


def _write_report(
    path: Path,
    results: "Sequence[tuple[Path, FlightLog, Calibration]]",
    points: "Sequence[Sequence[FixedSpeedPoint]]",
) -> None:
    from pitotbench.bench import write_text
    from pitotbench.show.report import log_page
    from pitotbench.show.section import log_section

    sections = [
        log_section(source.name, log, result, beside)
        for (source, log, result), beside in zip(results, points, strict=True)
    ]
    title = "Pitot-static calibration: " + ", ".join(source.name for source, _, _ in results)
    write_text(path, log_page(title, "from measured logs", sections))


def add_campaign(parser: argparse.ArgumentParser) -> None:
    """The flags of a campaign, shared by `pitotbench campaign` and `scripts/run_campaign.py`."""
    from pitotbench.simulate.maneuvers import MANEUVERS, PAPER_MANEUVERS

    parser.add_argument(
        "--maneuver",
        required=True,
        help=f"{', '.join(MANEUVERS)}, a comma list, or all ({', '.join(PAPER_MANEUVERS)})",
    )
    parser.add_argument("--das", required=True, help="20/1, 50/50, 100/100, any A/G in Hz, a comma list, or all")
    parser.add_argument(
        "--model",
        default="inverse+",
        help="model, comma list, auto, or all: inverse+, quadratic, linear, bias (default: %(default)s)",
    )
    parser.add_argument("--method", default="covering", help="covering or paper (default: %(default)s)")
    parser.add_argument("--turbulence", default="light", help="none, light or moderate (default: %(default)s)")
    parser.add_argument("--wind-kt", type=float, default=15.0, help="wind speed [kt] (default: %(default)g)")
    parser.add_argument(
        "--wind-from-deg", type=float, default=300.0, help="wind direction [°] (default: %(default)g)"
    )
    parser.add_argument("--pilot", default="none", help="none, good or busy (default: %(default)s)")
    parser.add_argument("--aircraft", default="navajo", help="aircraft to fly (default: %(default)s)")
    parser.add_argument(
        "--seeds", type=int, default=1, help="flights of each maneuver: truth and sensor seeds 1 to N (default: 1)"
    )
    parser.add_argument("--jobs", type=int, help="processes (default: one a core)")
    parser.add_argument(
        "--scheduler", help="address of a dask scheduler, tcp://host:port, whose workers see the folder of --out"
    )
    parser.add_argument("--log-format", default="parquet", help="parquet, csv or mat (default: %(default)s)")
    parser.add_argument("--out", type=Path, help="folder for the results (default: out/<maneuver>-<das>)")
    parser.set_defaults(run=run_campaign)


def run_campaign(options: argparse.Namespace) -> int:
    """Fly a campaign, print its table and name its report."""
    from pitotbench.campaign.command import request_of, run_and_print

    return DONE if run_and_print(request_of(options)) else NO_ANSWER


def add_reconcile(parser: argparse.ArgumentParser) -> None:
    """The flags of a reconciliation, shared by `pitotbench reconcile` and `scripts/reconcile.py`."""
    parser.add_argument("log", type=Path, metavar="MEASURED", help="measured log (.csv, .parquet, .mat)")
    parser.add_argument(
        "--aircraft", default="navajo", help="aircraft model, or none: sensors alone (default: %(default)s)"
    )
    parser.add_argument(
        "--holdout", type=Path, metavar="LOG", help="another log, on which the gap is to shrink too"
    )
    parser.add_argument("--mapping", help="how to read a foreign log: a shipped name or a TOML file")
    parser.add_argument(
        "--card", type=Path, metavar="CASE", help="case file that says what was flown (default: the log's header)"
    )
    parser.add_argument("--apply", metavar="NAME", help="keep the patched aircraft as ./aircraft/<aircraft>+NAME")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--out", type=Path, help="folder for verdict.json and patch.toml")
    parser.set_defaults(run=run_reconcile)


def run_reconcile(options: argparse.Namespace) -> int:
    """Reconcile a log, print the verdict, write it and its patch."""
    from rich.console import Console

    from pitotbench.bench_reconcile import keep, reconcile
    from pitotbench.logbook import read_log
    from pitotbench.records.case_file import read_case
    from pitotbench.show.verdict import print_verdict, verdict_json

    log = read_log(options.log, options.mapping)
    other = read_log(options.holdout, options.mapping) if options.holdout else None
    card = read_case(options.card) if options.card else None
    found = reconcile(log, options.aircraft, other, card, progress=_say, setting=_setting(options.mapping))
    document = verdict_json(found.verdict)
    for line in keep(found, document, options.log.name, options.aircraft, options.out, options.apply):
        _say(line)
    if options.json:
        print(json.dumps(document, indent=1))
    else:
        print_verdict(found.verdict, Console(highlight=False, soft_wrap=True))
    return DONE


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _setting(mapping: str | None) -> "Setting":
    """What the mapping of a foreign log advises."""
    from pitotbench.bench_reconcile import Setting
    from pitotbench.logbook import find_mapping

    advised = find_mapping(mapping).calibrate if mapping else {}
    static = advised.get("error_location") == "static"
    mach = advised.get("mach_max")
    return Setting(static_error=static, mach_max=mach if isinstance(mach, float) else 1.0)


if __name__ == "__main__":
    sys.exit(main())
