"""The house keeps its budgets of statements and numbers; names in strings lead somewhere."""

import ast
import re
from pkgutil import resolve_name

from pitotbench.campaigns.digests import _FLYING_CAMPAIGNS, _NOT_FLYING
from pitotlab.house import PRODUCT, ROOT, long_lines, numbers_in, statements_in

STATEMENTS = 22_700  # of the product, without docstrings and imports; the goal is 19,000
NUMBERS = 2_780  # of the product, fields and defaults included; the goal is 2,200
LONG_LINES = 155  # of the product, above 100 characters


def test_the_product_keeps_its_budget_of_statements_and_numbers() -> None:
    assert statements_in(PRODUCT) <= STATEMENTS
    assert numbers_in(PRODUCT) <= NUMBERS


def test_lines_are_a_hundred_wide() -> None:
    assert long_lines(PRODUCT) <= LONG_LINES


def test_what_the_digest_of_a_flight_leaves_out_exists() -> None:
    for name in (*_NOT_FLYING, *_FLYING_CAMPAIGNS):
        assert (PRODUCT / name).exists(), name


def test_every_name_of_the_product_in_a_string_leads_to_something() -> None:
    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in (ROOT / "src").rglob("*.py"))
    texts = (
        node.value for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Constant)
    )
    names = {
        text
        for text in texts
        if isinstance(text, str) and re.fullmatch(r"pitotbench(\.[a-z_A-Z]\w*)+", text)
    }
    assert len(names) > 10
    for name in sorted(names):
        resolve_name(name)
