"""The numbers that decide a verdict stand in one record, each with its reason."""

import ast
import inspect
import re
from dataclasses import fields
from pathlib import Path

import pytest

from pitotbench.reconcile.decide import thresholds
from pitotbench.reconcile.decide.thresholds import THRESHOLDS, Thresholds

RECONCILE = Path(thresholds.__file__).parents[1]
PACKAGE = RECONCILE.parent
# Effort of a search, guards against a division by zero, mathematical constants, and digits: they decide nothing.
NO_THRESHOLDS = {
    *("STEMS", "RENEWALS", "RENEWED", "LISTED", "NEAR", "FAR", "DIGITS", "MEAN_SCORE", "EULER"),
    *(
        "SMALLEST",
        "SMALLEST_GAIN",
        "SINGULAR",
        "ROUNDING",
        "BLOCKS",
        "TINY",
        "LOWEST",
        "LEAST_POWER",
        "SMOOTH_LEAST",
        "SEEN",
        "SECONDS_A_MINUTE",
    ),
    *("LEADING", "STEMS", "BEAM", "EXTENDED", "ROUNDS", "SETTLED", "RESTED", "SHIFT", "LEAST_SHARE"),
}
DECIDING = [
    *(f for f in sorted((RECONCILE / "decide").glob("*.py")) if f.name not in ("thresholds.py", "locate.py")),
    *sorted((RECONCILE / "null_flights").glob("*.py")),
    RECONCILE / "log_checks.py",
]


@pytest.mark.parametrize("name", [field.name for field in fields(Thresholds)])
def test_every_threshold_has_its_reason_and_is_used(name: str) -> None:
    (line,) = (text for text in inspect.getsource(Thresholds).splitlines() if re.match(rf"    {name}: ", text))
    assert "#" in line
    folders = (RECONCILE, PACKAGE / "bench" / "reconcile")
    code = "\n".join(file.read_text("utf-8") for folder in folders for file in folder.rglob("*.py"))
    assert re.search(rf"THRESHOLDS\.{name}\b", code)


@pytest.mark.parametrize("file", DECIDING, ids=lambda file: file.name)
def test_no_other_number_of_a_deciding_module_is_a_threshold(file: Path) -> None:
    named: set[str] = set()
    for node in ast.parse(file.read_text("utf-8")).body:
        if isinstance(node, ast.Assign) and any(
            isinstance(n, ast.Constant) and isinstance(n.value, int | float) for n in ast.walk(node.value)
        ):
            named |= {name.id for target in node.targets for name in ast.walk(target) if isinstance(name, ast.Name)}
    assert {name for name in named if name.isupper()} <= NO_THRESHOLDS


def test_a_threshold_cannot_be_changed() -> None:
    with pytest.raises(AttributeError):
        THRESHOLDS.named_from = 1.0  # type: ignore[misc]
