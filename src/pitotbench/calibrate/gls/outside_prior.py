"""Warnings for nuisances and noise parameters that the log puts far outside their priors.

Where the log contradicts a prior, the estimate is a compromise between the two, and the bound is too small. The
sensor, its unit or the assumption is wrong; only the user can decide which.

A log that hardly knows a nuisance moves its estimate little, however wrong the prior. So an estimate is held
against what the prior lets such logs find, its prior predictive distribution: where the prior has standard
deviation s and the posterior r, estimates scatter by √(s² − r²) (Box, "Sampling and Bayes' inference in scientific
modelling and robustness", Journal of the Royal Statistical Society A 143, 1980).
"""

from dataclasses import dataclass

import numpy as np

from pitotbench.calibrate.gls.altitude_noise import NOISE_COUNT, SLOW_SCALE, SLOW_TIME, SLOW_TIME_FACTOR, WALK_SCALE
from pitotbench.calibrate.gls.altitude_noise import WHITE_SCALE as HEIGHT_SCALE
from pitotbench.calibrate.gls.covering_fit import CoveringFit
from pitotbench.calibrate.gls.linearized_problem import (
    GUST_LENGTH,
    GUST_SCALE,
    WHITE_SCALE,
    WIND_SCALE,
    Structure,
    length_factor,
)
from pitotbench.calibrate.gls.posterior import Posterior
from pitotbench.calibrate.model.nuisances import Nuisance
from pitotbench.calibrate.rows.observations import Observations

_FAR = 3.0  # standard deviations of the prior of a noise parameter
_SELDOM = 2.58  # standard deviations of a nuisance's estimates: 1 % of logs are farther
_LEAST_KNOWN = 0.04  # share of the prior variance: a log that resolves less says nothing of a nuisance

_ERRORS = {  # name of a nuisance to its words and its unit
    "temperature_k": ("constant error of the temperature", "K"),
    "recovery_factor": ("error of the recovery factor", ""),
    "static_pressure_pa": ("constant error of the static pressure", "Pa"),
    "impact_pressure_zero_pa": ("zero offset of the impact pressure", "Pa"),
    "velocity_north_mps": ("constant error of the GPS velocity toward north", "m/s"),
    "velocity_east_mps": ("constant error of the GPS velocity toward east", "m/s"),
    "latency_s": ("latency of the GPS", "s"),
    "wind_north_mps_per_600_s": ("change of the wind toward north in 600 s", "m/s"),
    "wind_east_mps_per_600_s": ("change of the wind toward east in 600 s", "m/s"),
    "wind_north_mps_per_300_m": ("change of the wind toward north over 300 m of height", "m/s"),
    "wind_east_mps_per_300_m": ("change of the wind toward east over 300 m of height", "m/s"),
}


@dataclass(frozen=True, slots=True)
class _Level:
    """A level with a half-normal prior of the given scale."""

    words: str
    unit: str
    scale: float

    def departure(self, value: float) -> float:
        """Distance from zero in standard deviations."""
        return value / self.scale

    @property
    def expected(self) -> str:
        """The assumed size, in words."""
        return f"at most about {2.0 * self.scale:.3g} {self.unit} expected"


@dataclass(frozen=True, slots=True)
class _Extent:
    """A length or a time with a log-normal prior: its middle, and one standard deviation as a factor."""

    words: str
    unit: str
    middle: float
    factor: float

    def departure(self, value: float) -> float:
        """Distance of the logarithm from that of the middle, in standard deviations, without sign."""
        return float(abs(np.log(value / self.middle)) / np.log(self.factor))

    @property
    def expected(self) -> str:
        """The assumed size, in words."""
        reach = self.factor**2
        return f"{self.middle / reach:.3g} to {self.middle * reach:.3g} {self.unit} expected"


def outside_prior(structure: Structure, obs: Observations, fit: CoveringFit, answer: Posterior) -> tuple[str, ...]:
    """Write a sentence for each nuisance and each noise parameter far outside its prior.

    Far is what 1 % of logs find of a nuisance where its prior holds, and for a noise parameter more than three
    standard deviations of the prior from its middle. The sentence states the size.
    """
    return (*_nuisances_outside(structure, answer), *_noise_outside(structure, obs, fit))


def _nuisances_outside(structure: Structure, answer: Posterior) -> list[str]:
    mean, bounds = answer.mean, answer.two_sigma(np.eye(len(answer.mean)))
    found = []
    for place, nuisance in enumerate(structure.nuisances, start=structure.model.count):
        # The scatter for known noise: the nodes' own differences are no knowledge of the nuisance.
        left = float(answer.weights @ answer.covariances[:, place, place]) / nuisance.deviation**2
        scatter = nuisance.deviation * float(np.sqrt(max(1.0 - left, _LEAST_KNOWN)))
        if abs(float(mean[place])) > _SELDOM * scatter:
            found.append(_nuisance_sentence(nuisance, float(mean[place]), float(bounds[place]), scatter))
    return found


def _nuisance_sentence(nuisance: Nuisance, value: float, bound: float, scatter: float) -> str:
    words, unit = _ERRORS.get(nuisance.name, (nuisance.name.replace("_", " "), ""))
    return (
        f"the {words} is found to be {_sized(f'{value:+.3g} ± {bound:.2g}', unit)}; under what was assumed "
        f"({_sized(f'±{2.0 * nuisance.deviation:.3g}', unit)}, 2σ) such a log would find "
        f"{_sized(f'0 ± {2.0 * scatter:.2g}', unit)}: check the sensor and its unit, or assume more"
    )


def _sized(number: str, unit: str) -> str:
    return f"{number}{unit}" if unit == "°" else f"{number} {unit}".rstrip()


def _noise_outside(structure: Structure, obs: Observations, fit: CoveringFit) -> list[str]:
    likely = np.exp(max(fit.nodes, key=lambda node: node.weight).noise)
    found = []
    for prior, value in zip(_noise_priors(structure, length_factor(obs)), likely, strict=True):
        departure = prior.departure(float(value))
        if departure > _FAR:
            found.append(
                f"the {prior.words} is found to be {value:.3g} {prior.unit}, {departure:.1f} standard deviations "
                f"of what was assumed ({prior.expected}): the bound may be too small; check the log for slow "
                "changes of the wind and for faulty channels"
            )
    return found


def _noise_priors(structure: Structure, factor: float) -> list[_Level | _Extent]:
    """The priors of the noise parameters in their order; `factor` is that of the gusts' length."""
    priors: list[_Level | _Extent] = [
        _Level("gusts' standard deviation", "m/s", GUST_SCALE),
        _Extent("gusts' length", "m", GUST_LENGTH, factor),
        _Level("white noise of the airspeed", "m/s", WHITE_SCALE),
    ]
    if structure.drifting:
        priors.append(_Level("standard deviation of the drifting wind", "m/s", WIND_SCALE))
    if structure.altitude is not None:
        third = (
            _Level("white noise of the height", "m", HEIGHT_SCALE)
            if structure.altitude.tie is None
            else _Level("wander of the integrated vertical velocity", "m/√s", WALK_SCALE)
        )
        height: list[_Level | _Extent] = [
            _Level("slow error of the height", "m", SLOW_SCALE),
            _Extent("memory of the height error", "s", SLOW_TIME, SLOW_TIME_FACTOR),
            third,
        ]
        assert len(height) == NOISE_COUNT
        priors += height
    return priors
