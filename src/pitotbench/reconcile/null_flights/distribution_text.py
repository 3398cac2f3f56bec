"""A null distribution as text and back; a text that cannot be right is refused."""

import json
from dataclasses import asdict, dataclass, fields
from typing import Annotated, Any

import numpy as np
from pydantic import Field, TypeAdapter

from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution, ScoreScale
from pitotbench.reconcile.null_flights.null_measure import Measure
from pitotbench.reconcile.residuals.whitening import NoiseModel

Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0.0)]
# Learning never lets a spread fall below this one.
Spread = Annotated[float, Field(allow_inf_nan=False, ge=THRESHOLDS.score_deviation_lowest)]


@dataclass(frozen=True, slots=True)
class _Measure:
    """The fields of a Measure, as JSON holds them."""

    mean: Finite
    deviation: Positive


@dataclass(frozen=True, slots=True)
class _Noise:
    """The fields of a NoiseModel, as JSON holds them."""

    names: tuple[str, ...]
    coefficients: list[list[Finite]]
    deviations: list[Positive]
    correlation: list[list[Finite]]


@dataclass(frozen=True, slots=True)
class _Scale:
    """The fields of a ScoreScale, as JSON holds them."""

    search_gain: dict[str, Finite]
    effect_spread: dict[str, Spread]
    cell_mean: dict[str, Finite]
    cell_spread: dict[str, Spread]
    fluctuation: dict[str, Spread]
    left_over: dict[str, Spread]


@dataclass(frozen=True, slots=True)
class _Text:
    """The fields of a NullDistribution, as JSON holds them, with the rules that its numbers must obey."""

    noise: _Noise
    scores: _Scale
    threshold: Positive
    cell_threshold: Positive
    flights: Annotated[int, Field(ge=THRESHOLDS.null_flights_fewest)]
    gust_levels: dict[str, _Measure]
    channel_powers: dict[str, _Measure]
    spectral_lines: dict[str, _Measure]


def text_of(null: NullDistribution) -> str:
    """Return a null distribution as JSON. Raises ValueError where a number in it is not finite."""
    return json.dumps(asdict(null), default=np.ndarray.tolist, allow_nan=False)


def read_distribution(text: str | bytes) -> NullDistribution:
    """Return the null distribution of a text that `text_of` wrote.

    Raises ValueError for any other text: cut, of another form, or with a number that learning cannot give (not
    finite, a threshold or a deviation of zero).
    """
    checked = TypeAdapter(_Text).validate_json(text, strict=True)
    return NullDistribution(
        noise=_noise(checked.noise),
        scores=ScoreScale(**_fields(checked.scores)),
        threshold=checked.threshold,
        cell_threshold=checked.cell_threshold,
        flights=checked.flights,
        gust_levels=_measures(checked.gust_levels),
        channel_powers=_measures(checked.channel_powers),
        spectral_lines=_measures(checked.spectral_lines),
    )


def _fields(checked: _Scale) -> dict[str, Any]:
    return {f.name: getattr(checked, f.name) for f in fields(checked)}


def _measures(checked: dict[str, _Measure]) -> dict[str, Measure]:
    return {name: Measure(each.mean, each.deviation) for name, each in checked.items()}


def _noise(checked: _Noise) -> NoiseModel:
    count = len(checked.names)
    rows = {
        *(len(checked.coefficients), len(checked.deviations), len(checked.correlation)),
        *map(len, checked.correlation),
    }
    if rows != {count} or len({len(row) for row in checked.coefficients}) != 1:
        raise ValueError(f"the noise of {count} channels has arrays of other lengths")
    arrays = (np.array(a) for a in (checked.coefficients, checked.deviations, checked.correlation))
    return NoiseModel(checked.names, *arrays)
