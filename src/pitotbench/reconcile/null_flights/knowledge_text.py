"""What null flights taught, as text and back; a text that cannot be right is refused."""

import json
from dataclasses import asdict, dataclass, fields
from typing import Annotated

import numpy as np
from pydantic import Field, TypeAdapter

from pitotbench.reconcile.null_flights.null_distribution import FEWEST, Knowledge
from pitotbench.reconcile.residuals.whitening import NoiseModel

Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0.0)]
Spread = Annotated[float, Field(allow_inf_nan=False, ge=1.0)]  # `learn` never lets one fall below one
Pairs = dict[str, tuple[Finite, Positive]]  # mean and deviation


@dataclass(frozen=True, slots=True)
class _Noise:
    """The fields of a NoiseModel, as JSON holds them."""

    names: tuple[str, ...]
    coefficients: list[list[Finite]]
    deviations: list[Positive]
    correlation: list[list[Finite]]


@dataclass(frozen=True, slots=True)
class _Text:
    """The fields of a Knowledge, as JSON holds them, and what must be true of their numbers."""

    noise: _Noise
    search: dict[str, Finite]
    spread: dict[str, Spread]
    cell_mean: dict[str, Finite]
    cell_spread: dict[str, Spread]
    threshold: Positive
    cell_threshold: Positive
    flights: Annotated[int, Field(ge=FEWEST)]
    gusts: Pairs
    powers: Pairs
    swings: Pairs


def knowledge_text(known: Knowledge) -> str:
    """Knowledge as JSON. Raises ValueError where a number in it is not finite."""
    return json.dumps(asdict(known), default=np.ndarray.tolist, allow_nan=False)


def read_knowledge(text: str | bytes) -> Knowledge:
    """The knowledge of a text that `knowledge_text` wrote.

    Raises ValueError for any other: cut, of another form, or with a number that `learn` cannot give (not finite, a
    threshold or a deviation of zero).
    """
    found = TypeAdapter(_Text).validate_json(text, strict=True)
    rest = {f.name: getattr(found, f.name) for f in fields(found) if f.name != "noise"}
    return Knowledge(noise=_noise(found.noise), **rest)


def _noise(found: _Noise) -> NoiseModel:
    count = len(found.names)
    rows = {len(found.coefficients), len(found.deviations), len(found.correlation), *map(len, found.correlation)}
    if rows != {count} or len({len(row) for row in found.coefficients}) != 1:
        raise ValueError(f"the noise of {count} channels has arrays of other lengths")
    arrays = (np.array(a) for a in (found.coefficients, found.deviations, found.correlation))
    return NoiseModel(found.names, *arrays)
