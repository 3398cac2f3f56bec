"""The house keeps its budgets of files and lines; names in strings lead somewhere."""

import ast
import re
from pkgutil import resolve_name

from pitotbench.bench.digests import _FLYING_BENCH, _NOT_FLYING
from pitotlab.house import PRODUCT, ROOT, long_modules, size_of

FILES = 175  # of the product
LINES = 45_247  # of the product; the goal is 35,000


def test_the_product_keeps_its_budget_of_files_and_lines() -> None:
    size = size_of(PRODUCT)
    assert size.files <= FILES
    assert size.lines <= LINES


def test_few_modules_are_long() -> None:
    assert len(long_modules()) <= 3, long_modules()


def test_what_the_digest_of_a_flight_leaves_out_exists() -> None:
    for name in (*_NOT_FLYING, *_FLYING_BENCH):
        assert (PRODUCT / name).exists(), name


def test_every_name_of_the_product_in_a_string_leads_to_something() -> None:
    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in (ROOT / "src").rglob("*.py"))
    texts = (node.value for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Constant))
    names = {text for text in texts if isinstance(text, str) and re.fullmatch(r"pitotbench(\.[a-z_A-Z]\w*)+", text)}
    assert len(names) > 10
    for name in sorted(names):
        resolve_name(name)
