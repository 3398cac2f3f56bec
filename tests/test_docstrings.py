"""Public docstrings say what a signature cannot: errors raised, shapes and units of arrays, sources of formulas.

The rules are counted over the whole package with its syntax trees:

- A public function, method or property has a docstring, which may be that of what it overrides.
- It names every class of error that it raises itself. An error raised inside a `try` may be caught there.
- Where its signature holds an array of no stated unit (`Array`), the shape is given, and the unit or that there is
  none. The class, the module or the package may say so once for all that is in it.
- A module of formulas names their source: author and year, or a standard.
"""

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

import pitotbench

PACKAGE = Path(pitotbench.__file__).parent
SHAPE = re.compile(r"\((?:[\w+·× -]+,)+[\w+ ·×-]*\)|shape|element by element|[Ss]calar|for each")
UNIT = re.compile(r"\[[^\]]+\]|\bSI\b|\bunits?\b|dimensionless")
SOURCE = re.compile(r"[A-Z]\w+[^.]{0,120}?\b(?:19|20)\d\d\b|MIL-|FAR |ISO ")
FORMULAS = ("air.py", "axes.py", "units.py", "estimate", "pressure_error", "simulate/atmosphere.py")
WITHOUT_FORMULA = {
    "estimate/joint_noise.py": "sums over independent rows",
    "pressure_error/curve.py": "an interface",
    "pressure_error/model.py": "an interface",
    "pressure_error/table_curve.py": "a linear interpolation",
}
# Packages whose arrays are described by figures and tables rather than read by a caller.
WITHOUT_ARRAYS = ("show",)


@dataclass(frozen=True)
class Public:
    """A public function: where it is, its tree, the docstring of itself and all that is said around it."""

    name: str
    tree: ast.FunctionDef
    own: str
    around: str


def _package_says(file: Path) -> str:
    texts = [ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""]
    init = file.parent / "__init__.py"
    texts.append(ast.get_docstring(ast.parse(init.read_text(encoding="utf-8"))) or "")
    return "\n".join(texts)


def _inside(body: list[ast.stmt], place: str, around: str, inherits: bool) -> Iterator[tuple[Public, bool]]:
    for part in body:
        if isinstance(part, ast.ClassDef) and not part.name.startswith("_"):
            said = around + "\n" + (ast.get_docstring(part) or "")
            yield from _inside(part.body, f"{place}:{part.name}", said, bool(part.bases))
        if isinstance(part, ast.FunctionDef) and not part.name.startswith("_"):
            yield Public(f"{place}:{part.name}", part, ast.get_docstring(part) or "", around), inherits


def _public() -> list[tuple[Public, bool]]:
    found: list[tuple[Public, bool]] = []
    for file in sorted(PACKAGE.rglob("*.py")):
        place = file.relative_to(PACKAGE).as_posix()
        body = ast.parse(file.read_text(encoding="utf-8")).body
        found += _inside(body, place, _package_says(file), inherits=False)
    return found


PUBLIC = _public()


def _raised(tree: ast.AST) -> Iterator[str]:
    """The classes of errors raised in a function, without those inside a `try` that has handlers."""
    for part in ast.iter_child_nodes(tree):
        if isinstance(part, ast.Try) and part.handlers:
            for outside in (*part.handlers, *part.orelse, *part.finalbody):
                yield from _raised(outside)
            continue
        if isinstance(part, ast.Raise) and isinstance(part.exc, ast.Call) and isinstance(part.exc.func, ast.Name):
            yield part.exc.func.id
        yield from _raised(part)


def _array(tree: ast.FunctionDef) -> bool:
    hints = [a.annotation for a in (*tree.args.args, *tree.args.kwonlyargs)] + [tree.returns]
    return any(re.search(r"\bArray\b", ast.unparse(hint)) for hint in hints if hint)


def _of_arrays() -> list[Public]:
    return [p for p, _ in PUBLIC if _array(p.tree) and not p.name.startswith(WITHOUT_ARRAYS)]


def test_there_is_something_to_count():
    assert len(PUBLIC) > 1000
    assert len(_of_arrays()) > 150


def _lacking() -> list[str]:
    """Every place where a rule is broken, with the rule."""
    found = [f"{p.name}: no docstring" for p, inherits in PUBLIC if not p.own and not inherits]
    for p, _ in PUBLIC:
        found += [f"{p.name}: raises {e}" for e in sorted(set(_raised(p.tree))) if e not in p.own + p.around]
    for what, rule in (("shape", SHAPE), ("unit", UNIT)):
        missing = [p for p in _of_arrays() if not rule.search(p.own) and not rule.search(p.around)]
        found += [f"{p.name}: no {what}" for p in missing]
    return found


def test_public_functions_name_their_errors_and_the_shapes_and_units_of_arrays():
    assert _lacking() == []


def test_every_module_of_formulas_names_its_source():
    files = [
        f
        for part in FORMULAS
        for f in ([PACKAGE / part] if part.endswith(".py") else (PACKAGE / part).glob("*.py"))
    ]
    modules = {f.relative_to(PACKAGE).as_posix(): f for f in files if f.name != "__init__.py"}
    assert set(WITHOUT_FORMULA) <= set(modules)
    lacking = [
        name
        for name, f in modules.items()
        if name not in WITHOUT_FORMULA and not SOURCE.search(f.read_text("utf-8"))
    ]
    assert lacking == []


@pytest.mark.parametrize("name", [n for n in pitotbench.__all__ if n != "__version__"])
def test_the_public_page_says_what_it_returns_and_raises(name):
    """What one imports from `pitotbench`: a function names its errors, a record of arrays their units."""
    thing = getattr(pitotbench, name)
    doc = thing.__doc__ or ""
    assert len(doc) > 40
    if not isinstance(thing, type):
        assert re.search(r"[Rr]aises", doc), f"{name} does not name its errors"


def test_the_rules_can_fail():
    tree = ast.parse(
        "def f(x: Array) -> int:\n  try:\n    raise A()\n  except A:\n    raise B() from None\n  raise C('x')"
    )
    function = tree.body[0]
    assert isinstance(function, ast.FunctionDef)
    assert sorted(_raised(function)) == ["B", "C"]
    assert _array(function)
    assert not SHAPE.search("Return the values.")
    assert not UNIT.search("Return the values.")
    assert not SOURCE.search("The usual formula.")
