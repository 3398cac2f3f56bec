"""Tables of named things, whose errors list the known names and the nearest one."""

from collections.abc import Callable, Iterator, Mapping
from difflib import get_close_matches
from typing import Generic, TypeVar

T = TypeVar("T")


class UnknownNameError(ValueError):
    """A name that the catalog does not hold. The message lists known names and the nearest."""


class Catalog(Mapping[str, T], Generic[T]):
    """An ordered, read-only table of named things: maneuvers, models, data systems, effects.

    A name that is not among the entries is looked up in what `made` makes of it, if anything:
    entries without number, which no list shows. Any other raises `UnknownNameError` with the known
    names and the nearest one.
    """

    def __init__(
        self,
        kind: str,
        entries: Mapping[str, T],
        made: Callable[[str], T | None] = lambda name: None,
    ) -> None:
        self.kind = kind
        self._entries = dict(entries)
        self._made = made

    def __getitem__(self, name: str) -> T:
        found = self._entries[name] if name in self._entries else self._made(str(name))
        if found is None:
            raise UnknownNameError(explain(self.kind, name, self._entries))
        return found

    def __contains__(self, name: object) -> bool:
        return name in self._entries or self._made(str(name)) is not None

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)


def explain(kind: str, name: str, known: Mapping[str, object] | list[str]) -> str:
    """Return a message that a name of a kind is unknown, with the nearest and all known names."""
    names = list(known)
    # The cutoff is difflib's share of matching letters: at 0.5 `circel` finds `circle`, and noise
    # finds nothing.
    near = get_close_matches(str(name), names, n=1, cutoff=0.5)
    hint = f" Did you mean {near[0]!r}?" if near else ""
    return f"unknown {kind} {name!r}.{hint} Known: {', '.join(names) or 'none'}."
