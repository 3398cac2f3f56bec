"""`pitotbench map`: draft a mapping for a log whose columns have unknown names."""

import argparse
import sys
from pathlib import Path

from pitotbench.cli.shared_flags import asked_flags, flag, stated_facts
from pitotbench.records import BadInputError
from pitotbench.records.calibration_request import FACTS, Reading

FLAGS = (
    flag("log", type=Path, metavar="LOG", help="log file with unknown column names"),
    flag("-o", "--out", type=Path, help="mapping to write (.toml); without it, it is printed"),
    *asked_flags(Reading, only=FACTS),
)


def run(options: argparse.Namespace) -> int:
    """Draft the mapping, and write or print it with what is to be checked; return exit code 0."""
    from pitotbench.logbook.bundle import is_bundle
    from pitotbench.logbook.columns import write_text
    from pitotbench.logbook.drafting import draft_mapping, mapping_text
    from pitotbench.logbook.reading import needs_mapping, read_table, with_facts
    from pitotbench.logbook.recognition import kind_of
    from pitotbench.records.outputs import require_file
    from pitotbench.show.columns import printable

    if options.out is not None:
        require_file(options.out, [".toml"], [options.log])
    if is_bundle(options.log):
        raise BadInputError(f"{options.log}: a folder; name a log in it")
    try:
        if known := needs_mapping(options.log):
            print(printable(f"{options.log.name}: {known}"))
            return 0
        drafted = draft_mapping(with_facts(read_table(options.log), stated_facts(options)))
        if drafted.missing and (kind := kind_of(options.log, options.log)):
            raise BadInputError(kind)
    except BadInputError as error:
        raise BadInputError(f"{options.log}: {error}") from error
    text = mapping_text(drafted, options.log.name)
    if options.out is None:
        sys.stdout.write(printable(text, keep="\n"))
        return 0
    write_text(options.out, text)
    use = f"pitotbench calibrate {options.log} --mapping {options.out}"
    first = "complete it first" if drafted.unusable else "answer the questions"
    refused = [drafted.refusal] if drafted.refusal else []
    lines = [
        text.splitlines()[0].removeprefix("# "),
        *(f"missing: no column was found for {name}" for name in drafted.missing),
        *(
            f"check {line.guess.theirs!r} = {line.guess.target()!r}: {line.question}"
            for line in drafted.lines
            if line.question
        ),
        *(f"with these lines the log is refused: {why}" for why in refused),
        f"use it: {use}" if drafted.sure else f"{first}, then: {use}",
    ]
    print("\n".join(map(printable, lines)))
    return 0
