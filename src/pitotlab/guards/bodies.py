"""The code of two trees as multisets of bodies, whatever module holds them: what vanished, and what
is new.

A body is a function, a method, what a class holds beside its methods, a constant of a module, or
another statement of a module. Docstrings and imports do not count. A name that is imported under
another name counts as the original, and `module.name` as `name`, so that a body that moves with its
imports stays equal. A string that names a module counts as `<module>`: that it exists is another
guard's question.
"""

import ast
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

ROOTS = ("src", "tests", "scripts")
GUARDS = ("pitotlab.guards", "tests.lab.test_guards")  # which only today's tree need have
Renames = Mapping[
    str, Mapping[str, str]
]  # `*`, a module, or `module:function` of the old tree to {old: new}
_Unit = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


@dataclass(frozen=True, slots=True)
class Body:
    """A body: its qualified name without the module, and its code."""

    name: str
    code: str


@dataclass(frozen=True, slots=True)
class Comparison:
    """Bodies of the old tree that the new one lacks, and the reverse, each with a module that holds
    it.
    """

    total: int
    gone: Mapping[Body, str]
    new: Mapping[Body, str]
    fewer: Mapping[Body, str] = field(default_factory=dict)  # twins merged: a copy remains


@dataclass(frozen=True, slots=True)
class _Tree:
    """The modules of a tree by dotted name, and where each imported name comes from."""

    modules: Mapping[str, ast.Module]
    renames: Renames
    passed_on: Mapping[
        tuple[str, str], tuple[str, str]
    ]  # name imported by a module to where it comes from

    def origin(self, module: str, name: str) -> tuple[str, str]:
        """Return module and name where a name is defined, through modules that only pass it on."""
        seen = set()
        while (module, name) not in seen and (module, name) in self.passed_on:
            seen.add((module, name))
            module, name = self.passed_on[module, name]
        return module, name

    def renamed(self, module: str, name: str, scope: str = "") -> str:
        """Return the new name of a name of a module, seen in a function of this name."""
        for key in (f"{module}:{scope}", module, "*"):
            if name in (table := self.renames.get(key, {})):
                return table[name]
        return name


def read_renames(path: Path | None) -> Renames:
    """Read a TOML file of tables `["*"]`, `["old.module"]` or `["old.module:Class.method"]` with
    old = "new".
    """
    return {} if path is None else tomllib.loads(path.read_text("utf-8"))


def read_tree(root: Path) -> dict[str, str]:
    """Return the sources of a checkout by dotted name; a package has the name of its folder."""
    sources = {}
    for top in ROOTS:
        base = root / "src" if top == "src" else root
        for path in sorted((root / top).rglob("*.py")):
            parts = path.relative_to(base).with_suffix("").parts
            sources[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path.read_text(
                "utf-8"
            )
    return sources


def compare(old: Mapping[str, str], new: Mapping[str, str], renames: Renames) -> Comparison:
    """Compare the bodies of two trees (module to source); the renames are applied to the old one."""
    before, after = _bodies(old, renames), _bodies(new, {})
    gone = {b: m[-1] for b, m in before.items() if b not in after}
    made = {b: m[-1] for b, m in after.items() if b not in before}
    more = {b: m[-1] for b, m in after.items() if b in before and len(m) > len(before[b])}
    fewer = {b: m[-1] for b, m in before.items() if b in after and len(m) > len(after[b])}
    return Comparison(sum(map(len, before.values())), gone, {**made, **more}, fewer)


def changed_pairs(found: Comparison) -> Iterator[tuple[str, str, str, str]]:
    """Yield name, module, old and new code; one code is empty where the name has no counterpart."""
    old, new = _by_name(found.gone), _by_name(found.new)
    for name in sorted({*old, *new}):
        ours, theirs = old.get(name, []), new.get(name, [])
        for i in range(max(len(ours), len(theirs))):
            (was, at), (now, here) = (
                each[i] if i < len(each) else ("", "") for each in (ours, theirs)
            )
            yield name, here or at, was, now


def _by_name(bodies: Mapping[Body, str]) -> dict[str, list[tuple[str, str]]]:
    out: dict[str, list[tuple[str, str]]] = defaultdict(list)
    for body, module in bodies.items():
        out[body.name].append((body.code, module))
    return out


def _bodies(sources: Mapping[str, str], renames: Renames) -> dict[Body, list[str]]:
    modules = {name: ast.parse(text) for name, text in sources.items()}
    passed_on = {
        (module, each.asname or each.name): (node.module, each.name)
        for module, parsed in modules.items()
        for node in ast.walk(parsed)
        if isinstance(node, ast.ImportFrom) and node.module
        for each in node.names
        if f"{node.module}.{each.name}" not in modules
    }
    tree = _Tree(modules, renames, passed_on)
    out: dict[Body, list[str]] = defaultdict(list)
    for module, parsed in tree.modules.items():
        if module.startswith(GUARDS):
            continue
        names = _imported(parsed, tree)
        for name, node in _units(_without_docstring(parsed.body), ""):
            scoped = _Plain(tree, module, name, *names)
            code = ast.unparse(scoped.visit(node))
            new = ".".join(tree.renamed(module, part) for part in name.split("."))
            if code:
                out[Body(new, code)].append(module)
    return out


def _imported(parsed: ast.Module, tree: _Tree) -> tuple[dict[str, str], dict[str, str]]:
    """Return the imported names of a module to their originals, and those that are modules to
    these.
    """
    originals, modules = {}, {}
    for node in ast.walk(parsed):
        if isinstance(node, ast.ImportFrom) and node.module:
            for each in node.names:
                here, whole = each.asname or each.name, f"{node.module}.{each.name}"
                if whole in tree.modules:
                    modules[here] = whole
                else:
                    originals[here] = tree.renamed(*tree.origin(node.module, each.name))
        elif isinstance(node, ast.Import):
            modules.update(
                {
                    each.asname or each.name: each.name
                    for each in node.names
                    if each.name in tree.modules
                }
            )
    return {here: name for here, name in originals.items() if here != name}, modules


def _units(body: Sequence[ast.stmt], inside: str) -> Iterator[tuple[str, ast.stmt]]:
    """Yield name and node of each body; a class is yielded without its methods, which follow."""
    for node in body:
        if isinstance(node, ast.ClassDef):
            methods = [n for n in node.body if isinstance(n, _Unit)]
            node.body = [n for n in node.body if n not in methods]
            yield inside + node.name, node
            yield from _units(methods, f"{inside}{node.name}.")
        elif isinstance(node, _Unit):
            yield inside + node.name, node
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            if (name := ast.unparse(target)) != "__all__":
                yield name, node
        elif not isinstance(node, ast.Import | ast.ImportFrom):
            yield "(a statement of a module)", node


def _without_docstring(body: Sequence[ast.stmt]) -> list[ast.stmt]:
    first = body[0] if body else None
    is_text = (
        isinstance(first, ast.Expr)
        and isinstance(first.value, ast.Constant)
        and isinstance(first.value.value, str)
    )
    return list(body[1:] if is_text else body)


class _Plain(ast.NodeTransformer):
    """A body without docstrings and imports, with the original and then the new names."""

    def __init__(
        self,
        tree: _Tree,
        module: str,
        scope: str,
        originals: Mapping[str, str],
        modules: Mapping[str, str],
    ) -> None:
        self.tree, self.module, self.scope = tree, module, scope
        self.originals, self.modules = originals, modules
        self.bound: Counter[str] = Counter()

    def visit(self, node: ast.AST) -> ast.AST:
        """Note the names that are bound in the body before it is changed."""
        if not self.bound:
            self.bound.update(n.arg for n in ast.walk(node) if isinstance(n, ast.arg))
            self.bound.update(
                n.id
                for n in ast.walk(node)
                if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
            )
            self.bound["in a body"] = 1
        done: ast.AST | None = super().visit(node)
        return ast.Module([], []) if done is None else done

    def generic_visit(self, node: ast.AST) -> ast.AST:
        """Leave docstrings and imports out; a block that held nothing else holds `pass`, an empty
        `if` goes.
        """
        for name, value in ast.iter_fields(node):
            if name in ("body", "orelse", "finalbody") and isinstance(value, list):
                body = (
                    _without_docstring(value)
                    if name == "body" and isinstance(node, _Unit)
                    else value
                )
                kept = [n for n in body if not isinstance(n, ast.Import | ast.ImportFrom)]
                setattr(node, name, kept or ([ast.Pass()] if name == "body" else []))
        super().generic_visit(node)
        if isinstance(node, ast.If) and isinstance(node.body[0], ast.Pass) and not node.orelse:
            return ast.Pass()
        return node

    def visit_Name(self, node: ast.Name) -> ast.AST:
        known = self.originals.get(node.id) if node.id not in self.bound else None
        return ast.Name(known or self._new(node.id), node.ctx)

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        home = (
            self.modules.get(ast.unparse(node.value))
            if isinstance(node.value, ast.Name | ast.Attribute)
            else None
        )
        if home is not None and ast.unparse(node.value) not in self.bound:
            return ast.Name(self.tree.renamed(*self.tree.origin(home, node.attr)), node.ctx)
        self.generic_visit(node)
        return ast.Attribute(node.value, self._new(node.attr), node.ctx)

    def visit_arg(self, node: ast.arg) -> ast.AST:
        self.generic_visit(node)
        return ast.arg(self._new(node.arg), node.annotation)

    def visit_keyword(self, node: ast.keyword) -> ast.AST:
        self.generic_visit(node)
        return ast.keyword(node.arg and self._new(node.arg), node.value)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        return self._named(node)

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        return self._named(node)

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if isinstance(node.value, str) and "." in node.value and " " not in node.value:
            return ast.Constant(self._without_module(node.value))
        return node

    def _named(self, node: _Unit) -> ast.AST:
        self.generic_visit(node)
        node.name = self._new(node.name)
        return node

    def _new(self, name: str) -> str:
        return self.tree.renamed(self.module, name, self.scope)

    def _without_module(self, text: str) -> str:
        """Return a string with `<module>` in place of a module's dotted name or path that it begins
        with.
        """
        parts = text.removesuffix(".py").removeprefix("src/").replace("/", ".").split(".")
        for count in range(len(parts), 1, -1):
            dotted = ".".join(parts[:count])
            if dotted in self.tree.modules or f"pitotbench.{dotted}" in self.tree.modules:
                return ".".join(["<module>", *parts[count:]])
        return text
