"""Every module, attribute, folder or file that a text of today's tree names exists in it."""

import ast
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from pitotlab.guards.bodies import read_tree

TEXTS = (
    "pyproject.toml",
    "Makefile",
    ".ci/run",
    "README.md",
    "docs/**/*.md",
    "src/**/*.toml",
    "src/**/*.html",
)
CODE = ("src/**/*.py", "tests/**/*.py", "scripts/*.py", "docs/conf.py")
_DOTTED = re.compile(r"(?<![\w./@-])(?:pitotbench|pitotlab|tests)(?:\.[A-Za-z_]\w*)+(?![\w(/-])")
_PATH = re.compile(r"(?<![\w./<>~-])(?:src|tests|docs|scripts)/[\w./*-]*")
_MADE = ("docs/study", "docs/conf")  # folders into which commands write when they are told to
_OF_OTHER_TREES = ("docs/CHANGELOG.md", "src/pitotlab/guards/", "tests/lab/test_guards.py")
_OF_FILES = ("toml", "md", "csv", "log", "git", "html")  # ends of file names, not of modules


def missing_names(tree: Path, before: Path | None = None) -> Iterator[str]:
    """Yield `file:line: name` for each name that names nothing in a tree.

    A string of the code also counts that named a module or a file of the product before, such as
    `records.errors`.
    """
    modules = {name: _defined(text) for name, text in read_tree(tree).items()}
    old = _product(before) if before else set()
    now = _product(tree)
    for pattern in (*CODE, *TEXTS):
        for path in sorted(tree.glob(pattern)):
            text = path.read_text("utf-8")
            place = path.relative_to(tree).as_posix()
            if place.startswith(_OF_OTHER_TREES):
                continue
            for found in _DOTTED.finditer(text):
                last = found[0].rsplit(".", 1)[-1]
                if last not in (*_OF_FILES, "no_such_name") and not _exists(found[0], modules):
                    yield f"{place}:{text.count(chr(10), 0, found.start()) + 1}: {found[0]}"
            for found in _PATH.finditer(text):
                if not _is_there(tree, found[0].rstrip(".-")):
                    yield f"{place}:{text.count(chr(10), 0, found.start()) + 1}: {found[0]}"
            if path.suffix == ".py":
                for node in ast.walk(ast.parse(text)):
                    if (
                        isinstance(node, ast.Constant)
                        and isinstance(node.value, str)
                        and node.value in old - now
                    ):
                        yield f"{place}:{node.lineno}: {node.value!r} was a module or a file"


def _exists(dotted: str, modules: Mapping[str, set[str]]) -> bool:
    """Return whether a dotted name is a module, a package, or one followed by a name that stands in
    it.
    """
    parts = dotted.split(".")
    for count in range(len(parts), 0, -1):
        head = ".".join(parts[:count])
        if head in modules:
            return count == len(parts) or parts[count] in modules[head]
        if count == len(parts) and any(name.startswith(f"{head}.") for name in modules):
            return True  # a folder of tests without __init__
    return False


def _defined(source: str) -> set[str]:
    """Return the names at the top of a module; where it resolves names lazily, also those in its
    strings.
    """
    out: set[str] = set()
    parsed = ast.parse(source)
    for node in ast.walk(parsed):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            out.add(node.name)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            out.update((each.asname or each.name).split(".")[0] for each in node.names)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            out.add(node.id)
    if "__getattr__" in out:
        out.update(
            n.value
            for n in ast.walk(parsed)
            if isinstance(n, ast.Constant) and isinstance(n.value, str)
        )
    return out | {"__version__", "__file__", "__main__"}


def _is_there(tree: Path, name: str) -> bool:
    if name.startswith(_MADE):
        return True
    return (
        any(tree.glob(name))
        if "*" in name
        else (tree / name).exists() or any(tree.glob(f"{name}*"))
    )


def _product(tree: Path) -> set[str]:
    """Return the modules of the product as `a.b`, and its files as `a/b.py`, seen from its folder."""
    root = tree / "src" / "pitotbench"
    files = [
        path.relative_to(root)
        for path in root.rglob("*.py")
        if len(path.relative_to(root).parts) > 1
    ]
    modules = {".".join(each.with_suffix("").parts).removesuffix(".__init__") for each in files}
    return {each.as_posix() for each in files} | {
        each for each in modules if "." in each
    }  # `plan` is a word
