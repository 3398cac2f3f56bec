"""The gauge of the house counts what a job enters; names in strings lead somewhere."""

import ast
import re
from pathlib import Path
from pkgutil import resolve_name

import pytest

from pitotbench.campaigns.digests import _FLYING_CAMPAIGNS, _NOT_FLYING
from pitotlab.house import PRODUCT, ROOT, long_lines, numbers_in, reach, statements_in

LONG_LINES = 67  # of the product, above 100 characters
JOB = '''
from functools import cache

def job():
    """Nested functions count where they are called, docstrings and imports never."""
    import os

    def called():
        return [each for each in (3, 4)]

    def not_called():
        called()
        return 5

    class Small:
        size: float = 6.5

    return called()

@cache
def seldom(times=7):
    return times
'''
MAIN = "if __name__ == '__main__':\n    job()\n    seldom()\n"


@pytest.mark.parametrize("split", [False, True], ids=["in one file", "in two files"])
def test_what_a_job_enters_is_the_same_in_one_file_and_in_two(tmp_path: Path, split: bool) -> None:
    package = tmp_path / "small"
    package.mkdir()
    first, second = JOB.split("@cache")
    files = {"job.py": first, "seldom.py": f"from functools import cache\n\n@cache{second}"}
    texts = {"job.py": JOB} if not split else files
    for name, text in texts.items():
        (package / name).write_text(text, encoding="utf-8")
    imports = "".join(f"from small.{name.removesuffix('.py')} import *\n" for name in texts)
    (package / "__main__.py").write_text(imports + MAIN, encoding="utf-8")
    found = reach(["small"], tmp_path, package)
    # job 6 with its own head, called 2, seldom 2
    assert (found.functions, found.statements) == (3, 10)
    assert found.files == tuple(texts)


def test_a_number_counts_where_it_stands_and_a_statement_once(tmp_path: Path) -> None:
    (tmp_path / "job.py").write_text(f"LIMIT = -3.5\n{JOB}", encoding="utf-8")
    assert numbers_in(tmp_path) == {"constants": 1, "fields": 1, "functions": 4}
    assert statements_in(tmp_path) == 12


def test_lines_are_a_hundred_wide() -> None:
    found = long_lines(PRODUCT)
    assert len(found) <= LONG_LINES, found


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
