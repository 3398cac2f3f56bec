"""The unknowns beside curve and wind: columns with priors, and what they change in the air data."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.special import ndtr

from pitotbench import air
from pitotbench.airdata import LIMITS as GAUGES
from pitotbench.airdata import Rest
from pitotbench.calibration.observations import Observations
from pitotbench.calibration.options import (
    WITHOUT_TEMPERATURE,
    Accuracies,
    CalibrationOptions,
    Priors,
    accuracies_of,
    priors_of,
    stated_wind,
)
from pitotbench.calibration.prediction import Prediction
from pitotbench.estimation.mixture import Posterior
from pitotbench.units import DEGREE, Array, Meters, MetersPerSecond, Pascal

# Wide priors of a wind that changes: by 5 m/s in ten minutes (`linear`), and in 300 m of height
# (every wind but the constant one), is one standard deviation.
_WIND_TIME = 600.0  # s
_WIND_HEIGHT = 300.0  # m
_LEAST_HEIGHT = 1.0  # m: keeps a layer from having no thickness
_LEAST_LAYER = 150.0  # m, of the thinnest layer in which the wind changes by one slope
_MOST_LAYERS = 8

ZERO = "impact_pressure_zero_pa"  # the only nuisance that enters the correction of a reading
LATENCY, SMOOTHING = "latency_s", "receiver_smoothing_s2"
_AXES = ("north", "east")

Column = Callable[[Prediction, Observations], MetersPerSecond]
HeightColumn = Callable[["HeightState"], Array]
Change = Callable[[Observations], Array | float]
Share = Callable[[Pascal, Array], Array]  # of impact pressure and load factor, Δp/q_c per unit


@dataclass(frozen=True, slots=True)
class Nuisance:
    """One unknown with a Gaussian prior of mean zero.

    A nuisance is estimated together with the curve and the wind. It is one number with a mean of
    zero, and its effect on the predicted airspeed is proportional to it. The first order is enough:
    an error of 3 K in the temperature changes the airspeed by 0.5 %, and the neglected second order
    is below 0.003 % of the airspeed.

    `name` ends in the unit and `deviation` is the prior's standard deviation in it. `column` gives
    the change of the predicted true airspeed per unit, (n,) [m/s]. `wind` is the axis (0 north, 1
    east) of one that changes the wind, and its change from row to row; None for another. `height`
    gives the change of the altitude rows per unit [m], None for none; `of_source` states that this
    is an error of the static source, and no other place of the error shows in the height.
    `positive` states that the prior is half-normal. Where its effect is not above `planned`, the
    airspeed says nothing of it. `measured` is what rows outside the flight say of it, with its
    standard deviation; None where they say nothing.
    """

    name: str
    deviation: float
    column: Column
    wind: tuple[int, Change] | None = None
    height: HeightColumn | None = None
    of_source: bool = False
    positive: bool = False
    planned: float = 0.0
    measured: tuple[float, float] | None = None

    def known(self) -> tuple[float, float]:
        """The mean and the precision of what is known before the flight is looked at."""
        value, deviation = self.measured or (0.0, np.inf)
        precision = self.deviation**-2.0 + deviation**-2.0
        return value * deviation**-2.0 / precision, precision


@dataclass(frozen=True, slots=True)
class HeightState:
    """What a column of the altitude rows is made of, (n,) each.

    `gain` are meters per pascal, `impact_pressure` [Pa] is indicated and 0 at rest, `load` is the
    load factor, `climb` [m/s] the climb rate, and `temperature_slope` the change of the column's
    height per kelvin [m/K].
    """

    gain: Array
    impact_pressure: Pascal
    load: Array
    climb: MetersPerSecond
    temperature_slope: Array


def nuisances_of(options: CalibrationOptions, obs: Observations) -> tuple[Nuisance, ...]:
    """Return the nuisances of a log, those without an accuracy left out.

    The accuracies of its header must already be in the options.
    """
    stated, priors = accuracies_of(options.accuracies, {}), priors_of(options.priors)
    temperature = max(stated.temperature_k, WITHOUT_TEMPERATURE if obs.standard_day else 0.0)
    probe_heated = 1.0 if obs.probe_heating > 0.0 else 0.0  # an air temperature needs no recovery
    known = (
        Nuisance(
            "temperature_k",
            0.5 * temperature,
            _by_temperature,
            height=lambda rows: rows.temperature_slope,
        ),
        Nuisance("recovery_factor", 0.5 * stated.recovery_factor * probe_heated, _by_recovery),
        Nuisance("static_pressure_pa", 0.5 * stated.static_pressure_pa, _by_static_pressure),
        _zero(obs.rests, stated, priors),
        *(
            Nuisance(f"velocity_{a}_mps", 0.5 * stated.velocity_mps, _wind(i))
            for i, a in enumerate(_AXES)
        ),
        *_latencies(options, stated, priors, options.use_altitude and obs.altitude is not None),
        Nuisance(SMOOTHING, _smoothing(options, obs), _by_smoothing, positive=True),
        _of_pressure("turn_lift", priors.turn_lift, _turn_lift(obs)),
    )
    change = priors.wind_change_mps
    layers = () if options.wind == "constant" or stated_wind(options.wind) else _layers(obs, change)
    linear = _linear_wind(obs, change) if options.wind == "linear" else ()
    return (*(n for n in known if n.deviation > 0.0), *linear, *layers)


_GUSTY = 2.0  # times its change, the mean pressure of a wind whose gusts are a quarter of it


def _zero(rests: Sequence[Rest], stated: Accuracies, priors: Priors) -> Nuisance:
    """The zero of the impact pressure, as it reads at rest where the log has rows at rest.

    There a wind may blow into the tube, and until the flight the zero moves.
    """
    wide = Nuisance(ZERO, 0.5 * stated.impact_pressure_zero_pa, lambda p, o: 1.0 / p.slope)
    if not rests:
        return wide
    readings = [each.reading_pa for each in rests]
    parts = (
        *(max(_GUSTY * each.gusts_pa for each in rests), max(each.noise_pa for each in rests)),
        *(priors.zero_drift_pa, 0.5 * float(np.ptp(readings))),
    )
    measured = float(np.mean(readings)), float(np.linalg.norm(parts))
    return replace(wide, deviation=max(wide.deviation, GAUGES.zero), measured=measured)


def _smoothing(options: CalibrationOptions, obs: Observations) -> float:
    """The prior of the square of the receiver's time constant [s²].

    A mean over T is a smoothing of T²/12, and a filter of first order one of the square of its
    latency. A velocity from positions is no mean: it was formed along their arcs.
    """
    own = priors_of(options.priors).receiver_smoothing_s2
    apart = float(np.median(np.diff(obs.time[obs.fresh]))) if obs.fresh.sum() > 1 else 0.0
    mean = 0.0 if obs.of_fixes else apart**2 / 12.0
    return (own + mean + options.gps_latency**2) * (own > 0.0)


def with_filter(
    nuisances: Sequence[Nuisance], found: Array, covariance: Array
) -> tuple[Nuisance, ...]:
    """Widen the prior of the smoothing by the mean square of the latency that was found.

    The nuisances have an estimate (m,) and a covariance (m, m). A filter makes both, and none makes
    the velocity early.
    """
    names = [each.name for each in nuisances]
    if LATENCY not in names:
        return tuple(nuisances)
    place = names.index(LATENCY)
    late, spread = float(found[place]), float(np.sqrt(covariance[place, place]))
    share, density = float(ndtr(late / spread)), np.exp(-0.5 * (late / spread) ** 2)
    squared = (late**2 + spread**2) * share + late * spread * density / np.sqrt(2.0 * np.pi)
    return tuple(
        replace(each, deviation=each.deviation + squared) if each.name == SMOOTHING else each
        for each in nuisances
    )


# m/s²: an idle deceleration has 1, the response to moderate turbulence 0.1
_PLANNED = 0.4


def _latencies(
    options: CalibrationOptions, stated: Accuracies, priors: Priors, height: bool
) -> tuple[Nuisance, ...]:
    """The latency of the GPS velocity, and that of its height beyond that of the velocity.

    The ground speed responds to gusts, by an airspeed hold or by drag alone, and these small
    accelerations imitate a latency (simulated flights without latency gave −1.0 to −1.5 s on
    circles and level legs). So only larger ones, planned, are the instrument.
    """
    free = options.latency != "given"
    return (
        Nuisance(
            LATENCY,
            max(0.5 * stated.latency_s, priors.latency_s * free),
            by_latency,
            height=lambda rows: -rows.climb,
            planned=_PLANNED * free,
        ),
        Nuisance(
            "height_latency_s",
            priors.height_latency_s * (free and height),
            lambda prediction, obs: np.zeros(len(obs)),
            height=lambda rows: -rows.climb,
        ),
    )


def with_signs(answer: Posterior, nuisances: Sequence[Nuisance], first: int) -> Posterior:
    """Return an answer in which the nuisances that are `positive` are.

    `first` is the place of the first nuisance.
    """
    for place, nuisance in enumerate(nuisances, start=first):
        if nuisance.positive:
            answer = answer.not_negative(place)
    return answer


def _of_pressure(name: str, deviation: float, share: Share) -> Nuisance:
    """An error of the static source beside that of level flight, a share of the impact pressure."""

    def column(prediction: Prediction, obs: Observations) -> MetersPerSecond:
        load = load_factor(_across(prediction, obs))
        return share(prediction.indicated, load) * prediction.by_error / prediction.slope

    def height(rows: HeightState) -> Meters:
        flying = np.maximum(rows.impact_pressure, 1.0)
        return rows.gain * rows.impact_pressure * share(flying, rows.load)

    return Nuisance(name, deviation, column, height=height, of_source=True)


def _turn_lift(obs: Observations) -> Share:
    """What a turn adds to the lift that the curve of level flight holds.

    In a turn the lift coefficient is n/q: the curve holds 1/q, and n − 1 is left. One in the middle
    of the flown ln q_ci.
    """
    low, high = np.quantile(obs.impact_pressure, [0.001, 0.999])
    middle = float(np.sqrt(low * high))
    return lambda impact, load: (load - 1.0) * middle / impact


def in_turns() -> Nuisance:
    """Return an error of the static source in turns, as sideslip makes it.

    It grows with the tangent of the bank. Its unit is the impact pressure at 30° of bank.
    """
    return _of_pressure(
        "turns", 1.0, lambda impact, load: np.sqrt(load**2 - 1.0) / np.tan(30.0 * DEGREE)
    )


def of_slow_probe(obs: Observations) -> Nuisance:
    """A probe whose error is proportional to 1/q_ci: one is a kelvin at the rows' slow end."""
    slow = float(np.quantile(obs.impact_pressure, 0.001))
    return Nuisance(
        "slow_probe_k",
        1.0,
        lambda p, o: _by_temperature(p, o) * slow / np.maximum(p.indicated, slow),
    )


_BANKED = air.GRAVITY * float(np.tan(10.0 * DEGREE))  # m/s², of a row that counts as turning
_LEAST_TURNING, _ONE_SIDE = 0.1, 0.95  # of the rows, and of those that turn


def side_of_turns(prediction: Prediction, obs: Observations) -> str:
    """Return the side of all turns, `left` or `right`; "" where they are to both, or few."""
    across = -_across(prediction, obs)
    turning = across[np.abs(across) > _BANKED]
    if len(turning) < _LEAST_TURNING * len(across):
        return ""
    right = float(np.mean(turning > 0.0))
    return "right" if right > _ONE_SIDE else "left" if right < 1.0 - _ONE_SIDE else ""


def along_track(prediction: Prediction) -> Array:
    """Return the change of predicted airspeed per unit of wind to north and east, (n, 2) [-].

    Minus the direction cosines of the air velocity.
    """
    return prediction.wind_columns[:, :2] / prediction.slope[:, None]


def _linear_wind(obs: Observations, deviation: float) -> tuple[Nuisance, ...]:
    """The wind's change with time, toward north and east."""
    middle = 0.5 * (obs.time[0] + obs.time[-1])
    return _both_axes({"per_600_s": lambda o: (o.time - middle) / _WIND_TIME}, deviation)


def _layers(obs: Observations, deviation: float) -> tuple[Nuisance, ...]:
    """The wind's change with height, a slope a layer of 150 m or more; one slope over less."""
    low, high = (float(edge) for edge in np.quantile(obs.height(), [0.01, 0.99]))
    high = max(high, low + _LEAST_HEIGHT)
    count = min(max(int((high - low) / _LEAST_LAYER), 1), _MOST_LAYERS)
    edges = np.linspace(low, high, count + 1)
    if count == 1:
        changes = {"per_300_m": _slope(obs, low, high)}
    else:
        changes = {
            f"per_300_m_above_{low:.0f}_m": _slope(obs, low, high) for low, high in pairwise(edges)
        }
    # Over many heights the changes of a wind add up as those of a random walk do.
    thickness = max((high - low) / count, _WIND_HEIGHT)
    return _both_axes(changes, deviation * float(np.sqrt(_WIND_HEIGHT / thickness)))


def _slope(flown: Observations, low: float, high: float) -> Change:
    """A change by one in 300 m between two heights [m], zero in the mean of what was flown.

    Below and above there is none.
    """
    middle = float(np.mean(np.clip(flown.height(), low, high)))
    return lambda obs: (np.clip(obs.height(), low, high) - middle) / _WIND_HEIGHT


def _both_axes(changes: Mapping[str, Change], deviation: float) -> tuple[Nuisance, ...]:
    return tuple(
        Nuisance(f"wind_{name}_mps_{unit}", deviation, _wind(axis, change), (axis, change))
        for unit, change in changes.items()
        for axis, name in enumerate(_AXES)
    )


def path_of_nuisances(nuisances: Sequence[Nuisance], values: Array, obs: Observations) -> Array:
    """Return the wind that nuisances of values (m,) add to each row, (n, 2) [m/s].

    The wind is toward north and east.
    """
    added = np.zeros((len(obs), 2))
    for nuisance, value in zip(nuisances, values, strict=True):
        if nuisance.wind is not None:
            axis, change = nuisance.wind
            added[:, axis] += value * change(obs)
    return added


def _wind(axis: int, change: Change = lambda obs: 1.0) -> Column:
    """The effect of a wind toward an axis (0 north, 1 east), times its change from row to row."""
    return lambda prediction, obs: along_track(prediction)[:, axis] * change(obs)


def _by_temperature(prediction: Prediction, obs: Observations) -> MetersPerSecond:
    # V = M sqrt(γRT): the same ground velocity in warmer air is a smaller Mach number and impact
    # pressure.
    return -0.5 * prediction.true_airspeed / obs.probe_temperature


def _by_recovery(prediction: Prediction, obs: Observations) -> MetersPerSecond:
    # T = T_t/(1 + 0.2 r M²): more recovery means colder air for the same reading.
    heat = air.HEAT_RATIO * air.GAS_CONSTANT * obs.probe_temperature
    return 0.1 * prediction.true_airspeed**3 / heat


def _by_static_pressure(prediction: Prediction, obs: Observations) -> MetersPerSecond:
    # The impact pressure of a Mach number is proportional to the static pressure.
    return prediction.indicated / (obs.static_pressure * prediction.slope)


def by_latency(prediction: Prediction, obs: Observations) -> MetersPerSecond:
    """Return the change of predicted airspeed per second of GPS latency, (n,) [m/s].

    The change is the ground acceleration along the airspeed.
    """
    return np.asarray(-np.einsum("na,na->n", along_track(prediction), obs.acceleration))


def _across(prediction: Prediction, obs: Observations) -> Array:
    """The acceleration over the ground across the path through the air, (n,) [m/s²]."""
    north, east = along_track(prediction).T
    return np.asarray(north * obs.acceleration[:, 1] - east * obs.acceleration[:, 0])


def _by_smoothing(prediction: Prediction, obs: Observations) -> MetersPerSecond:
    """Change of the predicted airspeed per s² of τ², the smoothing of the velocity.

    A velocity that turns at ω and is smoothed over τ is too short by 1/√(1 + ω²τ²), of which the
    first term is kept.

    A mean over T is a smoothing with τ² = T²/12.
    """
    return np.asarray(0.5 * _across(prediction, obs) ** 2 / prediction.true_airspeed)


def load_factor(across: Array) -> Array:
    """The load factor of a level turn, (n,) [-], by the acceleration across it, (n,) [m/s²]."""
    return np.asarray(np.hypot(1.0, across / air.GRAVITY))
