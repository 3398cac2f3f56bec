"""How many of ten foreign headers get the right mapping without help, and what is asked about the others.

    python -m tests.logbook.drafted_headers

drafts a mapping for each header of `foreign_headers`, reads the log, and compares it with the flight.
"""

from dataclasses import astuple, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.logbook import foreign_files as foreign
from tests.logbook.foreign_headers import HEADERS, write_header
from tests.logbook.formats import Readings, difference

from pitotbench.logbook.drafting import draft_mapping, mapping_text
from pitotbench.logbook.reading import read_log, read_table
from pitotbench.records import BadInputError
from pitotbench.records.log import FlightLog

NEAR = Readings(0.01, 0.1, 0.01, 0.01, 0.01)  # files with every digit: a wrong column or unit is off by far more


@dataclass(frozen=True)
class Drafted:
    """What `draft_mapping` made of a header: right or wrong, the columns it took, and its questions."""

    name: str
    right: bool
    columns: int
    questions: tuple[str, ...]


def draft(name: str, folder: Path) -> Drafted:
    """Draft the mapping of a header as it stands, and judge the log that is read by it."""
    flown = foreign.flight()
    path, mapping = write_header(folder / "log.csv", name, flown), folder / "m.toml"
    drafted = draft_mapping(read_table(path))
    mapping.write_text(mapping_text(drafted, path.name), encoding="utf-8")
    questions = [*(f"{line.guess.theirs}: {line.question}" for line in drafted.lines if line.question)]
    questions += [f"no column for {quantity}" for quantity in drafted.missing]
    questions += [drafted.refusal] if drafted.refusal else []
    return Drafted(name, _reads_right(path, mapping, flown), len(drafted.lines), tuple(questions))


def _reads_right(path: Path, mapping: Path, flown: dict[str, foreign.Array]) -> bool:
    try:
        log = read_log(path, mapping)
    except BadInputError:
        return False
    apart = astuple(difference(log, FlightLog(**flown)))
    return all(a <= near for a, near in zip(apart, astuple(NEAR), strict=True))


def main() -> None:
    """Print a line a header and the figure."""
    found = []
    for name in HEADERS:
        with TemporaryDirectory() as folder:
            found.append(draft(name, Path(folder)))
        result = found[-1]
        said = "; ".join(result.questions) or "no question"
        print(f"{name:<10} {'right' if result.right else 'WRONG'}  {result.columns:>2} columns  {said}")
    print(f"{sum(result.right for result in found)} of {len(found)} headers are drafted right without help")


if __name__ == "__main__":
    main()
