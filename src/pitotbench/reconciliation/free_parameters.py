"""The free parameters of every log: wind, error curve, sensor biases and the day's air.

Unknown in every log, they must not pass for an effect. Each is a column of the regression with a
prior standard deviation: wide for what nobody knows (wind, curve, sea-level pressure and
temperature), the accuracy class of the usual instrument for a bias.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench import air
from pitotbench.estimation.information import information_from
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.reconciliation.flight_path import PATH_SCALES, WIND
from pitotbench.reconciliation.replay import RATES
from pitotbench.reconciliation.residuals import ReferenceState
from pitotbench.reconciliation.track import Track, mach_number
from pitotbench.scatter import robust_deviation
from pitotbench.units import Array, Booleans

WIND_DEVIATION = (40.0, 40.0, 1.0)  # m/s toward north, east, down
CURVE = MODELS["inverse+"]  # the error curve that every log may have
CURVE_DEVIATION = 0.2  # of each parameter of Δp/q_c
LARGEST_ERROR = 0.5  # share of the impact pressure; a curve that asks for more comes from a log that is no flight
BIAS = {  # rad and rad/s: vanes and attitude as usually rigged and aligned, and usual gyros
    "angle_of_attack": 0.005,
    "sideslip": 0.005,
    "roll": 0.005,
    "pitch": 0.005,
    "heading": 0.010,
    **dict.fromkeys(RATES, 0.001),
}
ANGLE_SCALE = {"angle_of_attack": 0.02, "sideslip": 0.02}  # share: upwash that was not calibrated
# Share by which the quick changes of the angles of the path can be off: most of them are answers to
# gusts, which the path does not show, so that nothing is known of their scale.
PATH_SCALE = dict.fromkeys(PATH_SCALES, 1.0)
# The free parameters of the vanes: the channel and the kind of each.
VANE_PARAMETERS = {
    f"{name} {kind}": (name, kind) for name in ANGLE_SCALE for kind in ("bias", "scale")
}
FOREIGN = 5.0  # times these deviations, for a log whose instruments are not known
OFFSETS = {  # prior deviation of a residual channel [its unit]
    "pressure_height": 500.0,
    "temperature": 30.0,
    "acceleration_down": 0.05,
    "specific_force_x": 0.005,
    "specific_force_y": 0.02,
    "specific_force_z": 0.02,
}
REPORTED = {
    "pressure_height": 3.0,
    "temperature": 0.3,
}  # m (0.36 hPa), K: the day's air from a weather report
WITH_HEIGHT = {"pressure_height": 0.05, "temperature": 0.005}  # a meter of height: the day's lapse
EARTH_RATE = 1.5e-4  # rad/s, twice the earth's rate; the latitude decides which share of it acts
ROUNDING_DEVIATION = float(1.0 / np.sqrt(12.0))  # of a number rounded to whole steps, in steps
# Steps for the difference quotients: small compared with the priors, large compared with rounding.
BIAS_STEP = 0.002  # rad
SCALE_STEP = 0.01  # a share
CURVE_STEP = 0.01  # a share


@dataclass(frozen=True, slots=True)
class FreeParameters:
    """The free parameters as columns of the regression.

    `columns` holds the change of the residuals by one unit of each, (n, c, k); `deviations` their
    prior standard deviations, (k,).
    """

    names: tuple[str, ...]
    columns: Array
    deviations: Array

    def beyond(self, names: Sequence[str]) -> dict[str, tuple[Array, float]]:
        """Return the parameters that are not among some names: column (n, c) and deviation."""
        return {
            name: (self.columns[:, :, i], float(self.deviations[i]))
            for i, name in enumerate(self.names)
            if name not in names
        }

    def with_columns(self, further: Mapping[str, tuple[Array, float]]) -> "FreeParameters":
        """Return these and further parameters, by name the column (n, c) and the deviation.

        A column is the change of the residuals.
        """
        if not further:
            return self
        columns, deviations = zip(*further.values(), strict=True)
        return FreeParameters(
            (*self.names, *further),
            np.concatenate([self.columns, np.stack(columns, axis=2)], axis=2),
            np.concatenate([self.deviations, deviations]),
        )


@dataclass(frozen=True, slots=True)
class AnalysisSetting:
    """Facts about a log that its rows do not hold.

    `day_known`: pressure and temperature of the air are those of a weather report.
    `instruments_known`: the instruments are of the usual class, as they are wherever the day is
    known. `static_error`: the error curve sits in the static pressure, not in the impact pressure
    alone. Instants above `mach_max` are not used. `pressure_step` [Pa] is the step of a coarse
    quantization, 0 for none. With `terms` those of the aircraft's own file compete as well.
    `maneuvers`: the log is made of these, so that its floor is its own, and no cause is looked for
    in a part of it.
    """

    day_known: bool = False
    instruments_known: bool = False
    static_error: bool = False
    mach_max: float = 1.0
    pressure_step: float = 0.0
    terms: bool = False
    maneuvers: bool = False


@dataclass(frozen=True, slots=True)
class _Column:
    """Change of the residuals by one unit, (n, c), with the deviation of the prior."""

    values: Array
    deviation: float


Change = Callable[[Track], Track]
Columns = dict[str, _Column]


@dataclass(frozen=True, slots=True)
class _Variation:
    """A change of the track by a step of a parameter, with the deviation of its prior."""

    change: Change
    step: float
    deviation: float


def free_parameters_of(
    reference: ReferenceState, setting: AnalysisSetting, shapes: Array
) -> FreeParameters:
    """Return the free parameters that the residual channels of a log need.

    `shapes` (n, k) are those of the cells: a coarse rounding error may follow each of them.
    """
    columns: Columns = {}
    for name, variation in _variations(reference.clean, setting).items():
        moved = reference.change_by(variation.change(reference.clean))
        columns[name] = _Column(moved / variation.step, variation.deviation)
    columns |= _wind(reference) | _offsets(reference, setting.day_known)
    columns |= _coriolis(reference)
    columns |= _rounding(reference, setting, shapes)
    values = np.stack([column.values for column in columns.values()], axis=2)
    deviations = np.array([column.deviation for column in columns.values()])
    return FreeParameters(tuple(columns), values, deviations)


def _rounding(reference: ReferenceState, setting: AnalysisSetting, shapes: Array) -> Columns:
    """Columns for a coarse step, which rounds a steady pressure in the same way for long.

    The rounding error is then constant over a phase of flight, or it follows a variable.
    """
    columns: Columns = {}
    step = setting.pressure_step
    for name in ("impact_pressure", "static_pressure") if step else ():
        moved = reference.change_by(_shifted(name, step)(reference.clean))
        for i, shape in enumerate(shapes.T):
            columns[f"{name} rounding {i}"] = _Column(moved * shape[:, None], ROUNDING_DEVIATION)
    return columns


def _variations(clean: Track, setting: AnalysisSetting) -> Mapping[str, _Variation]:
    """The parameters that act on a track: the error curve, and the angles' biases and scales."""
    variations: dict[str, _Variation] = {}
    basis = CURVE.basis(clean["impact_pressure"] / REFERENCE_PRESSURE)
    for i, name in enumerate(CURVE.parameter_names):
        change = _curved(basis[:, i], setting.static_error)
        variations[f"curve {name}"] = _Variation(change, CURVE_STEP, CURVE_DEVIATION)
    wider = 1.0 if setting.day_known or setting.instruments_known else FOREIGN
    for name, deviation in BIAS.items():
        if name in clean:
            variations[f"{name} bias"] = _Variation(
                _shifted(name, BIAS_STEP), BIAS_STEP, wider * deviation
            )
    for name, deviation in ANGLE_SCALE.items():
        if name in clean:
            variations[f"{name} scale"] = _Variation(
                _scaled(name, 1.01), SCALE_STEP, wider * deviation
            )
    for name, deviation in PATH_SCALE.items():
        if name in clean:
            variations[name.replace("_", " ")] = _Variation(
                _shifted(name, SCALE_STEP), SCALE_STEP, deviation
            )
    return variations


def without_curve(track: Track, sizes: Mapping[str, float], setting: AnalysisSetting) -> Track:
    """Return a track without an error curve of these sizes; other names are ignored."""
    measured = track["impact_pressure"]
    true = _true_pressure(measured, sizes)
    corrected = {"impact_pressure": true}
    if setting.static_error:
        corrected["static_pressure"] = track["static_pressure"] - (true - measured)
    return track.replaced(corrected)


def with_vane_angles(track: Track, sizes: Mapping[str, float]) -> Track:
    """Return a track whose vanes have a scale and a zero of these sizes."""
    names = [name for name in ANGLE_SCALE if f"{name} bias" in sizes]
    return track.replaced(
        {n: (1.0 + sizes[f"{n} scale"]) * track[n] + sizes[f"{n} bias"] for n in names}
    )


def without_vane_angles(track: Track, sizes: Mapping[str, float]) -> Track:
    """Return the track from which `with_vane_angles` gives this one."""
    names = [name for name in ANGLE_SCALE if f"{name} bias" in sizes]
    return track.replaced(
        {n: (track[n] - sizes[f"{n} bias"]) / (1.0 + sizes[f"{n} scale"]) for n in names}
    )


def curve_of(impact_pressure: Array, rounds: Iterable[Mapping[str, float]]) -> Array:
    """Return Δp/q_c at indicated impact pressures [Pa], (n,), of curves taken out one by one."""
    true = impact_pressure
    for sizes in rounds:
        true = _true_pressure(true, sizes)
    return np.asarray(1.0 - impact_pressure / true)


def _true_pressure(indicated: Array, sizes: Mapping[str, float]) -> Array:
    return np.asarray(
        indicated / (1.0 - np.clip(curve_share(indicated, sizes), -LARGEST_ERROR, LARGEST_ERROR))
    )


def curve_share(impact_pressure: Array, sizes: Mapping[str, float]) -> Array:
    """Return Δp/q_c at indicated impact pressures [Pa], (n,), of a curve of these sizes.

    Sizes of other names are ignored.
    """
    basis = CURVE.basis(impact_pressure / REFERENCE_PRESSURE)
    share = np.zeros(len(impact_pressure))
    for i, name in enumerate(CURVE.parameter_names):
        share = share + sizes.get(f"curve {name}", 0.0) * basis[:, i]
    return share


def _curved(term: Array, static_error: bool) -> Change:
    """Add one hundredth of a term of the error curve, Δp = q_c − q_ci.

    An error of the static source shows in the static pressure as well.
    """

    def change(track: Track) -> Track:
        error = CURVE_STEP * term * track["impact_pressure"]
        changed = {"impact_pressure": track["impact_pressure"] - error}
        return track.replaced(
            changed
            | ({"static_pressure": track["static_pressure"] + error} if static_error else {})
        )

    return change


def _scaled(name: str, factor: float) -> Change:
    return lambda track: track.replaced({name: track[name] * factor})


def _shifted(name: str, step: float) -> Change:
    return lambda track: track.replaced({name: track[name] + step})


def _wind(reference: ReferenceState) -> Columns:
    columns = {}
    for i, (name, deviation) in enumerate(
        zip(("north", "east", "down"), WIND_DEVIATION, strict=True)
    ):
        toward = np.zeros((len(reference.grid), 3))
        toward[:, i] = 1.0
        columns[f"wind {name}"] = _Column(residuals_of_wind(toward, reference), deviation)
    return _that_act(columns)


def residuals_of_wind(wind: Array, reference: ReferenceState) -> Array:
    """Return the change of the residuals, (n, c), by a wind toward north, east, down [m/s], (n, 3).

    Along a path it is what the true wind has more than the mean wind by which the path is computed.
    """
    clean = reference.clean
    if WIND[0] not in clean:
        return _turned_into(reference, wind, "airspeed", ("along", "across", "down"))
    rows, own = reference.grid.rows, np.arange(len(clean.time))
    blown = {n: clean[n] + np.interp(own, rows, w) for n, w in zip(WIND, wind.T, strict=True)}
    return -reference.change_by(clean.replaced(blown))


def _offsets(reference: ReferenceState, day_known: bool) -> Columns:
    clean, grid, names = reference.clean, reference.grid, reference.base.names
    ones, columns = np.ones(len(grid)), {}
    # A warmer day is warmer at the probe by the ram rise as well.
    units = {"temperature": air.total_temperature(ones, grid.smooth(mach_number(clean)))}
    for name, deviation in (OFFSETS | (REPORTED if day_known else {})).items():
        if name in names:
            columns[f"{name} offset"] = _Column(
                _in_channel(reference, name, units.get(name, ones)), deviation
            )
    if "altitude" in clean:
        height = grid.smooth(clean["altitude"])
        for name, deviation in WITH_HEIGHT.items():
            if name in names:
                columns[f"{name} lapse"] = _Column(
                    _in_channel(reference, name, height - height.mean()), deviation
                )
    return columns


def _coriolis(reference: ReferenceState) -> Columns:
    """Columns for the Coriolis acceleration.

    The sine of the latitude acts in the horizontal, its cosine in the vertical.
    """
    clean, grid = reference.clean, reference.grid
    if reference.channel("acceleration_forward") is None:
        return {}
    north, east = grid.smooth(clean["velocity_north"]), grid.smooth(clean["velocity_east"])
    zero = np.zeros_like(east)
    vectors = {
        "earth turning": np.stack([-east, north, zero], axis=1),
        "earth lifting": np.stack([zero, zero, -east], axis=1),
    }
    columns = {}
    for name, vector in vectors.items():
        change = _turned_into(reference, vector, "acceleration", ("forward", "right", "down"))
        columns[name] = _Column(np.where(grid.first[:, None], 0.0, change), EARTH_RATE)
    return _that_act(columns)


def _turned_into(
    reference: ReferenceState, vectors: Array, family: str, axes: tuple[str, str, str]
) -> Array:
    """Return vectors toward north, east, down, (n, 3), as a family's channels along the track.

    The channels are those along, across and, where the residuals have it, down.
    """
    column = reference.blank()
    parts = reference.frame.turned(vectors, f"{family}_down" in reference.base.names)
    for i, axis in enumerate(axes[: parts.shape[1]]):
        column[:, reference.base.names.index(f"{family}_{axis}")] = parts[:, i]
    return column


def _that_act(columns: Columns) -> Columns:
    """The columns that change any residual: without a vertical velocity some do not."""
    return {name: column for name, column in columns.items() if column.values.any()}


def _in_channel(reference: ReferenceState, name: str, values: Array) -> Array:
    column = reference.blank()
    column[:, reference.base.names.index(name)] = values
    return column


SCALINGS = 3  # rounds of scaling the channels against each other; their noise is not known yet
TINY = 1e-12  # added to a scale: a channel without any change must not divide by zero


@dataclass(frozen=True, slots=True)
class ParameterFit:
    """Sizes of the free parameters, (k,), and what they leave.

    `deviations`, (k,), are those of the sizes, `residuals`, (n, c), those without them.
    """

    sizes: Array
    deviations: Array
    residuals: Array


def fit_free_parameters(values: Array, free: FreeParameters, usable: Booleans) -> ParameterFit:
    """Fit the free parameters to residuals (n, c) by least squares with priors.

    Only instants and channels that are `usable`, (n, c), enter. Each channel is scaled by the
    robust deviation of its remaining residuals.
    """
    columns, remaining, scale = free.columns, values, values.std(axis=0) + TINY
    every = range(columns.shape[2])
    for _ in range(SCALINGS):
        design = (columns * (usable / scale)[:, :, None]).reshape(-1, len(every))
        seen = design.T @ (values * usable / scale).ravel()
        found = information_from(design.T @ design, seen).posterior(every, free.deviations)
        remaining = values - columns @ found.mean
        scale = robust_deviation(remaining) + TINY
    return ParameterFit(found.mean, np.sqrt(np.diag(found.covariance)), remaining)
