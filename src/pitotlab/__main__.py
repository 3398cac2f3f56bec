"""`python -m pitotlab NAME`: run one measurement. A new one is a function and a line of the table."""

import os
import sys
from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter
from collections.abc import Sequence
from importlib import import_module

from pitotbench.cli.app import guarded
from pitotbench.cli.shared_flags import BAD_INPUT, DONE

# Name: module and function, which adds its flags to a parser, reads the words, and does the work.
COMMANDS = {
    "house": "pitotlab.house:command",
    "tables": "pitotlab.tables:command",
    "study": "pitotlab.study.conduct:command",
    "study questions": "pitotlab.study.conduct:questions_command",
    "study methods": "pitotlab.study.methods:command",
    "stale": "pitotlab.stale:command",
    "coverage": "pitotlab.coverage:command",
    "aircraft": "pitotlab.aircraft:command",
    "nulls": "pitotlab.null_tables:command",
    "reference": "pitotlab.reference_figures:command",
    "peers": "pitotlab.peers:command",
    "real": "pitotlab.real_logs:command",
    "gallery": "pitotlab.gallery:command",
    "outside write": "pitotlab.outside.written:command",
    "outside judge": "pitotlab.outside.judge:judge_command",
    "outside compare": "pitotlab.outside.judge:compare_command",
    "blind signatures": "pitotlab.blind.signatures:command",
    "blind generate": "pitotlab.blind.drawn:command",
    "blind analyze": "pitotlab.blind.analyze:blind_command",
    "blind pooled": "pitotlab.blind.score:pooled_command",
    "blind pack": "pitotlab.blind.sealed:command",
    "derivatives generate": "pitotlab.derivatives.generate:command",
    "derivatives judge": "pitotlab.blind.analyze:derivatives_command",
    "derivatives score": "pitotlab.derivatives.score:command",
    "speed": "pitotlab.speed.ratios:command",
    "parameters": "pitotlab.deliverables:parameters_command",
    "drills": "pitotlab.drills.costs:command",
    "door": "pitotlab.door:command",
    "broken": "pitotlab.broken.measure:command",
    "broken scales": "pitotlab.broken.scales:command",
}


def main(words: Sequence[str] | None = None) -> int:
    """Run the command that the first words name; return its exit code."""
    # As the commands of the product, before NumPy is loaded.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    given = list(sys.argv[1:] if words is None else words)
    name = next((" ".join(given[:n]) for n in (2, 1) if " ".join(given[:n]) in COMMANDS), None)
    if name is None:
        print("usage: python -m pitotlab NAME [--help]\n", *COMMANDS, sep="\n  ")
        return DONE if not given or given[0] in ("-h", "--help") else BAD_INPUT
    module, _, function = COMMANDS[name].partition(":")
    command = getattr(import_module(module), function)
    parser = ArgumentParser(
        prog=f"python -m pitotlab {name}",
        description=command.__doc__,
        formatter_class=RawDescriptionHelpFormatter,
    )
    rest = given[len(name.split()) :]
    return guarded(Namespace(run=lambda _: command(parser, rest) or DONE))


if __name__ == "__main__":
    sys.exit(main())
