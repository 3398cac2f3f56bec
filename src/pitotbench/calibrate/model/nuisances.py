"""The nuisances: quantities that are estimated together with the curve and the wind, each with its prior.

Every nuisance is one number with a mean of zero. Its effect on the predicted airspeed is proportional to it. The
first order is enough: an error of 3 K in the temperature changes the airspeed by 0.5 %, and the neglected second
order is below 0.003 % of the airspeed.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pitotbench import air
from pitotbench.calibrate.accuracy import WITHOUT_TEMPERATURE, accuracies_of
from pitotbench.calibrate.model.prediction import Prediction
from pitotbench.calibrate.options import CalibrationOptions
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.units import Array, Meters, MetersPerSecond

# Wide priors of a linear wind: a change of 5 m/s in ten minutes or in 300 m is one standard deviation.
_WIND_CHANGE = 5.0  # m/s
_WIND_TIME, _WIND_HEIGHT = 600.0, 300.0  # s, m
_LEAST_CLIMB = 60.0  # m: a smaller difference in height cannot determine a shear

ZERO = "impact_pressure_zero_pa"  # the only nuisance that enters the correction of a reading
_AXES = ("north", "east")

Column = Callable[[Prediction, Observations], MetersPerSecond]
Change = Callable[[Observations], Array | float]


@dataclass(frozen=True, slots=True)
class Nuisance:
    """One unknown with a Gaussian prior of mean zero.

    `name` ends in the unit and `deviation` is the prior's standard deviation in it. `column` gives the change of
    the predicted true airspeed per unit, (n,) [m/s].
    """

    name: str
    deviation: float
    column: Column


def nuisances_of(options: CalibrationOptions, obs: Observations) -> tuple[Nuisance, ...]:
    """The nuisances of a log. The accuracies of its header must already be in the options.

    A nuisance whose accuracy is zero is left out.
    """
    stated = accuracies_of(options.accuracies, {})
    temperature = max(stated.temperature_k, WITHOUT_TEMPERATURE if obs.standard_day else 0.0)
    probe_heated = 1.0 if obs.probe_heating > 0.0 else 0.0  # an air temperature needs no recovery
    known = (
        Nuisance("temperature_k", 0.5 * temperature, _by_temperature),
        Nuisance("recovery_factor", 0.5 * stated.recovery_factor * probe_heated, _by_recovery),
        Nuisance("static_pressure_pa", 0.5 * stated.static_pressure_pa, _by_static_pressure),
        Nuisance(ZERO, 0.5 * stated.impact_pressure_zero_pa, lambda p, o: 1.0 / p.slope),
        *(Nuisance(f"velocity_{a}_mps", 0.5 * stated.velocity_mps, _wind(i)) for i, a in enumerate(_AXES)),
        Nuisance("latency_s", 0.5 * stated.latency_s, by_latency),
    )
    changing = _linear_wind(obs) if options.wind == "linear" else ()
    return (*(n for n in known if n.deviation > 0.0), *changing)


def along_track(prediction: Prediction) -> Array:
    """Change of the predicted airspeed per unit of wind toward north and east, (n, 2) [-].

    It is minus the direction cosines of the air velocity.
    """
    return prediction.wind_columns[:, :2] / prediction.slope[:, None]


def _linear_wind(obs: Observations) -> tuple[Nuisance, ...]:
    """The wind's change with time and, where the log climbs, with height, toward north and east."""
    middle = 0.5 * (obs.time[0] + obs.time[-1])
    # These are functions of the rows: the search for a latency reads the rows again, and there may be fewer.
    changes: dict[str, Change] = {"per_600_s": lambda o: (o.time - middle) / _WIND_TIME}
    if obs.altitude is not None and np.ptp(obs.altitude) > _LEAST_CLIMB:
        mean = float(np.mean(obs.altitude))
        changes["per_300_m"] = lambda o: (_altitude(o) - mean) / _WIND_HEIGHT
    return tuple(
        Nuisance(f"wind_{name}_mps_{unit}", _WIND_CHANGE, _wind(axis, change))
        for unit, change in changes.items()
        for axis, name in enumerate(_AXES)
    )


def _wind(axis: int, change: Change = lambda obs: 1.0) -> Column:
    """The effect of a wind toward an axis (0 north, 1 east), times its change from row to row."""
    return lambda prediction, obs: along_track(prediction)[:, axis] * change(obs)


def _altitude(obs: Observations) -> Meters:
    assert obs.altitude is not None
    return obs.altitude


def _by_temperature(prediction: Prediction, obs: Observations) -> MetersPerSecond:
    # V = M sqrt(γRT): the same ground velocity in warmer air is a smaller Mach number and impact pressure.
    return -0.5 * prediction.true_airspeed / obs.probe_temperature


def _by_recovery(prediction: Prediction, obs: Observations) -> MetersPerSecond:
    # T = T_t/(1 + 0.2 r M²): more recovery means colder air for the same reading.
    heat = air.HEAT_RATIO * air.GAS_CONSTANT * obs.probe_temperature
    return 0.1 * prediction.true_airspeed**3 / heat


def _by_static_pressure(prediction: Prediction, obs: Observations) -> MetersPerSecond:
    # The impact pressure of a Mach number is proportional to the static pressure.
    return prediction.indicated / (obs.static_pressure * prediction.slope)


def by_latency(prediction: Prediction, obs: Observations) -> MetersPerSecond:
    """Change of the predicted airspeed per second of GPS latency, (n,) [m/s]: the ground acceleration along it."""
    return np.asarray(-np.sum(along_track(prediction) * _acceleration(obs), axis=1))


def _acceleration(obs: Observations) -> Array:
    """Acceleration over the ground toward north and east, (n, 2) [m/s²]."""
    return np.stack([_rate(v, obs) for v in (obs.velocity_north, obs.velocity_east)], axis=1)


def _rate(values: Array, obs: Observations) -> Array:
    """Time derivative; zero next to a pause, where the difference spans the pause."""
    rate = np.gradient(values, obs.time)
    edge = np.flatnonzero(np.diff(obs.stretch))
    rate[edge] = rate[edge + 1] = 0.0
    return rate
