"""Random values of fields: independent draws, or a Latin hypercube."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import exp, log
from statistics import NormalDist
from sys import float_info
from typing import Any

import numpy as np

from pitotbench.catalog import explain
from pitotbench.records import BadInputError

METHODS = ("random", "latin_hypercube")
_EXTRAS = {"log", "whole"}
_SPREADS = {"uniform": {"low", "high"}, "normal": {"mean", "sd"}, "choice": {"choose"}}


@dataclass(frozen=True, slots=True)
class Draws:
    """`count` draws of some fields.

    A field has a spread: `{low, high}` (uniform; with `log = true` in its logarithm; with `whole =
    true` in whole numbers, both ends included), `{mean, sd}` (normal) or `{choose = [...]}`. With
    the method `latin_hypercube` (McKay, Beckman and Conover 1979) every field has one draw in each
    of `count` equally likely intervals. Raises BadInputError for a spread that cannot be.
    """

    fields: Mapping[str, Mapping[str, Any]]
    count: int
    method: str = "random"
    seed: int = 1

    def __post_init__(self) -> None:
        if type(self.count) is not int or type(self.seed) is not int or self.seed < 0:
            raise BadInputError("draw: count and seed are whole numbers, such as seed = 1")
        if self.method not in METHODS:
            raise BadInputError(explain("method of draws", self.method, list(METHODS)))
        if self.count < 1 or not self.fields:
            raise BadInputError("draws need a count of at least 1 and at least one field")
        for name, spread in self.fields.items():
            _require_spread(name, spread)

    def values(self) -> Iterator[dict[str, Any]]:
        """Give the draws one by one.

        The first draws of a longer random plan are those of a shorter one.
        """
        if self.method == "latin_hypercube":
            from scipy.stats import qmc  # slow to load

            cube = qmc.LatinHypercube(d=len(self.fields), seed=np.random.default_rng(self.seed))
            yield from map(self._of, cube.random(self.count))
            return
        for number in range(self.count):
            yield self._of(np.random.default_rng([self.seed, number]).random(len(self.fields)))

    def middle(self) -> dict[str, Any]:
        """Return the medians, to try whether the fields exist."""
        return self._of(np.full(len(self.fields), 0.5))

    def _of(self, shares: Any) -> dict[str, Any]:
        return {
            name: _quantile(spread, float(share))
            for (name, spread), share in zip(self.fields.items(), shares, strict=True)
        }


def _quantile(spread: Mapping[str, Any], share: float) -> Any:
    """Return the value below which a share of a spread lies."""
    if "choose" in spread:
        return spread["choose"][min(int(share * len(spread["choose"])), len(spread["choose"]) - 1)]
    if "mean" in spread:
        # The ends of the normal distribution are infinite, and a share can be exactly 0.
        return NormalDist(spread["mean"], spread["sd"]).inv_cdf(min(max(share, 1e-12), 1.0 - 1e-12))
    low, high = spread["low"], spread["high"]
    if spread.get("whole"):
        return min(int(low + share * (high - low + 1)), int(high))
    if spread.get("log"):
        return exp(log(low) + share * (log(high) - log(low)))
    return low + share * (high - low)


def _require_spread(name: str, spread: Mapping[str, Any]) -> None:
    stated = set(spread) - _EXTRAS if isinstance(spread, Mapping) else set()
    if stated not in _SPREADS.values():
        raise BadInputError(
            f"draws of {name}: give {{low, high}}, {{mean, sd}} or {{choose = [...]}}"
        )
    if "choose" in stated:
        good = isinstance(spread["choose"], list) and len(spread["choose"]) > 0
    else:
        good = all(
            isinstance(spread[key], int | float) and abs(spread[key]) <= float_info.max
            for key in stated
        )
        if good and "low" in stated:
            good = spread["low"] <= spread["high"] and not (
                spread.get("log") and spread["low"] <= 0
            )
        elif good:
            good = spread["sd"] > 0
    if not good:
        raise BadInputError(
            f"draws of {name}: {dict(spread)} is no spread: low <= high, sd > 0, log above 0"
        )
