"""The checklists of `docs/howto/extend.md`, followed in a copy of the project: a maneuver, an effect
and a reader are added as they say, and the tests of the tables pass there.
"""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from pitotlab.house import ROOT

S_TURN = '''

@dataclass(frozen=True, slots=True, kw_only=True)
class LabTurnsCard(Card):
    """Ours: half a circle to one side and half a circle to the other at each speed."""

    speeds: tuple[float, ...] = quantity((160.0, 130.0, 100.0), "kt", decreasing=True)
    bank: float = quantity(30.0, "deg", steep=True)
    heading: float = quantity(0.0, "deg")
    bank_limit: float = quantity(35.0, "deg", positive=True)
    airspeed_tolerance: float = quantity(2.0, "kt")
    settle: float = quantity(8.0, "s")


def fly_lab_turns(cockpit: Cockpit, card: LabTurnsCard) -> Ticks:
    """Fly the card: at each speed set up unrecorded, then turn to the right and to the left."""
    for speed in card.speeds:
        yield from set_up(cockpit, speed, card.heading)
        for bank in (card.bank, -card.bank):
            cockpit.hold_bank(bank)
            what = f"{speed / KNOT:.0f} kt bank {degrees(bank):.0f}°"
            yield from settle(cockpit, f"settle {what}", JUDGED)
            cockpit.begin(f"circle {what}", *JUDGED)
            yield from sweep(cockpit, pi, bank)
'''
S_TURN_ROW = '    Maneuver("lab_turns", turns.LabTurnsCard(), turns.fly_lab_turns, None, "circle", turns.JUDGED),\n'
WING_ICE = """

WING_ICE = AircraftEffect(
    name="wing_ice",
    part="drag",
    parameters=(
        Parameter("drag_coefficient", 0.01, 0.0, 0.1, "added drag coefficient"),
        Parameter("lift_slope_lost_per_rad", 0.3, 0.0, 2.0, "lift slope that the ice takes away"),
    ),
    source="Bragg, Broeren and Blumenthal 2005, Iced-airfoil aerodynamics: roughness and horns",
    what="Ice on the wing adds drag and takes lift away.",
    shows_in=RANGE_OF_AIRSPEED,
    build=lambda effect, sizes, baseline: Overlay(
        sizes=effect.properties(sizes),
        functions=(
            coefficient_function("DRAG", product(size("wing_ice", "drag_coefficient"), 1.0)),
            coefficient_function(
                "LIFT", product(-1.0, size("wing_ice", "lift_slope_lost_per_rad"), "aero/alpha-rad")
            ),
        ),
    ),
)
"""
PAIRS_READER = '''

def read_pairs(path: Path) -> Table:
    """Return the rows of a file of pairs: `time_s=0.05 impact_pressure_pa=4120.5`, one line a row.

    Raises BadInputError for a file that is empty, cut off or of another kind.
    """
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    rows = [dict(pair.partition("=")[::2] for pair in line.split()) for line in lines]
    if not rows or any(row.keys() != rows[0].keys() for row in rows):
        raise BadInputError("not a log of pairs: each line names the same columns; copy it again")
    try:
        columns = [np.array([float(row[name]) for row in rows]) for name in rows[0]]
    except ValueError as error:
        raise BadInputError(f"not a log of pairs: {error}; copy it again") from error
    return Table(tuple(rows[0]), tuple(columns))
'''
READER_TEST = '''"""A log of pairs is the log of the same flight in CSV, and a broken one is refused."""

import numpy as np
import pytest

from pitotbench import BadInputError, Case, calibrate, fly, read_log, sense


def test_a_log_of_pairs_gives_the_calibration_of_the_same_log_in_csv(tmp_path):
    table = sense(fly(Case(maneuver="rapid_decel")), "20/1").to_frame().select_dtypes("number")
    table.to_csv(tmp_path / "log.csv", index=False)
    rows = (zip(table, row, strict=True) for row in table.itertuples(index=False))
    lines = [" ".join(f"{name}={float(value)!r}" for name, value in row) for row in rows]
    (tmp_path / "log.pairs").write_text("\\n".join(lines))
    answers = [calibrate(read_log(tmp_path / f"log.{suffix}")) for suffix in ("csv", "pairs")]
    one, other = (answer.curve for answer in answers)
    np.testing.assert_array_equal(one.correction, other.correction)


@pytest.mark.parametrize("text", ["", "time_s=0.0\\ntime_s", "time_s=0.0\\ntime_s=word"])
def test_a_broken_log_of_pairs_is_refused(tmp_path, text):
    (tmp_path / "log.pairs").write_text(text)
    with pytest.raises(BadInputError, match="pairs"):
        read_log(tmp_path / "log.pairs")
'''


@pytest.fixture(scope="module")
def extended(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A copy of the project with the three additions of the checklists."""
    copy = tmp_path_factory.mktemp("project")
    listed = subprocess.check_output(["git", "ls-files"], cwd=ROOT, text=True)
    for name in listed.splitlines():
        (copy / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, copy / name)
    product = copy / "src" / "pitotbench"

    maneuvers = product / "simulation" / "maneuvers"
    _append(maneuvers / "turns.py", S_TURN)
    _insert(maneuvers / "__init__.py", S_TURN_ROW, before=")\n\nMANEUVERS = Catalog(")
    case = product / "records" / "case.py"
    _insert(case, '        "lab_turns",\n', before='        "diagnostic",\n    ],')
    row = "| `lab_turns` | half circles to both sides; 160, 130, 100 KCAS | 5.0 | | |\n"
    _insert(copy / "docs" / "howto" / "plan-a-flight.md", row, before="| `cloverleaf` | three")

    _append(product / "effects" / "airframe.py", WING_ICE)
    answers = copy / "tests" / "simulation" / "test_effects_flown.py"
    _insert(answers, '    "wing_ice": ("power_left", 1),\n', before='    "induced_drag": (')

    _append(product / "logbook" / "csv.py", PAIRS_READER)
    formats = product / "logbook" / "formats.py"
    _insert(formats, "read_pairs, ", before="write_csv\nfrom")
    _insert(formats, '    ".pairs": read_pairs,\n', before='    ".tsv": read_csv')
    row = "| pairs, .pairs | `time_s=0.05 impact_pressure_pa=4120.5`, one line a row | |\n"
    _insert(copy / "docs" / "log.md", row, before="| IGC of a glider's recorder")
    (copy / "tests" / "logbook" / "test_pairs.py").write_text(READER_TEST, encoding="utf-8")

    entries = "`lab_turns`, `wing_ice` and logs of pairs.\n\n"
    _insert(copy / "docs" / "CHANGELOG.md", entries, before="`fixed-speed`: legs of a card may")
    assert _run(copy, "pitotlab", "tables") == ""  # what `make docs-tables` runs
    yield copy
    shutil.rmtree(copy)


def _append(file: Path, text: str) -> None:
    file.write_text(file.read_text(encoding="utf-8") + text, encoding="utf-8")


def _insert(file: Path, text: str, before: str) -> None:
    whole = file.read_text(encoding="utf-8")
    assert whole.count(before) == 1, (file, before)
    file.write_text(whole.replace(before, text + before), encoding="utf-8")


def _run(copy: Path, *arguments: str) -> str:
    """Run a module with the product of the copy; return what it said where it failed."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(copy / "src"), str(copy)])}
    done = subprocess.run(
        [sys.executable, "-m", *arguments],
        cwd=copy,
        env=environment,
        capture_output=True,
        text=True,
    )
    return done.stdout + done.stderr if done.returncode else ""


def _run_tests(copy: Path, *arguments: str) -> str:
    return _run(copy, "pytest", "-q", "-x", "-p", "no:cacheprovider", *arguments)


def test_a_maneuver_of_the_checklist_passes_the_tests_of_the_table(extended: Path) -> None:
    files = ("tests/simulation/test_maneuvers.py", "tests/campaigns/test_flights.py")
    assert _run_tests(extended, *files, "-k", "lab_turns") == ""


def test_an_effect_of_the_checklist_passes_the_tests_of_the_table(extended: Path) -> None:
    assert _run_tests(extended, "tests/effects/test_effects_table.py") == ""
    flown = "tests/simulation/test_effects_flown.py"
    assert _run_tests(extended, flown, "-k", "wing_ice or all_effects_of_zero_size") == ""


def test_a_reader_of_the_checklist_gives_the_calibration_of_the_same_log(extended: Path) -> None:
    assert _run_tests(extended, "tests/logbook/test_pairs.py") == ""


def test_the_additions_fit_into_the_house_and_its_pages(extended: Path) -> None:
    """A package has room for them, the pages hold them, and style and types pass."""
    room = "tests/lab/test_house_reach.py::test_what_carries_the_entries_of_a_table_does_not_grow"
    assert _run_tests(extended, "tests/test_documentation.py", "tests/test_house.py", room) == ""
    assert _run(extended, "ruff", "check", "src", "tests") == ""
    assert _run(extended, "ruff", "format", "--check", "src", "tests") == ""
