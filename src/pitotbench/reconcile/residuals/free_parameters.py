"""What is unknown in every log and must not pass for an effect: wind, error curve, sensor biases, the day's air.

Each is a column of the regression with a prior deviation: wide for what nobody knows (wind, curve, sea-level
pressure and temperature), the accuracy class of the usual instrument for a bias.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.reconcile.residuals.grid import Grid
from pitotbench.reconcile.residuals.predicted_channels import ChannelResiduals, Frame, channel_residuals
from pitotbench.reconcile.residuals.replay import Replay
from pitotbench.reconcile.residuals.track import Track
from pitotbench.units import Array

WIND_DEVIATION = (40.0, 40.0, 1.0)  # m/s toward north, east, down
CURVE_DEVIATION = 0.2  # of each parameter of Δp/q_c
MOST_ERROR = 0.5  # share of the impact pressure that is taken out at most
ANGLE_BIAS = {  # rad: vanes and attitude as usually rigged and aligned
    "angle_of_attack": 0.005,
    "sideslip": 0.005,
    "roll": 0.005,
    "pitch": 0.005,
    "heading": 0.010,
}
ANGLE_SCALE = {"angle_of_attack": 0.02, "sideslip": 0.02}  # share: upwash not taken out
FOREIGN = 5.0  # times these, for a log of which nothing is known
OFFSETS = {  # of a residual channel [its unit]
    "pressure_height": 500.0,
    "temperature": 30.0,
    "acceleration_down": 0.05,
    "specific_force_x": 0.005,
    "specific_force_y": 0.02,
    "specific_force_z": 0.02,
}
REPORTED = {"pressure_height": 3.0, "temperature": 0.3}  # m (0.36 hPa), K
WITH_HEIGHT = {"pressure_height": 0.05, "temperature": 0.005}  # a meter of height: the day's lapse
EARTH_RATE = 1.5e-4  # rad/s, twice the earth's, of which latitude lets a share act


@dataclass(frozen=True, slots=True)
class FreeParameters:
    """Columns of the regression: names, change of the residuals a unit, (n, c, k), prior deviations, (k,)."""

    names: tuple[str, ...]
    columns: Array
    deviations: Array


Change = Callable[[Track], Track]


@dataclass(frozen=True, slots=True)
class AnalysisSetting:
    """What is known of a log beyond its rows. `day_known`: the air's pressure and temperature are those of a
    weather report, and the instruments are of the usual class; `static_error`: the error curve sits in the static
    pressure, not in the impact pressure alone; rows above `mach_max` are not used."""

    day_known: bool = False
    static_error: bool = False
    mach_max: float = 1.0
    pressure_step: float = 0.0  # Pa, of a coarse quantization


def free_parameters_of(
    clean: Track,
    grid: Grid,
    frame: Frame,
    model: Replay | None,
    base: ChannelResiduals,
    known: AnalysisSetting,
    shapes: Array,
) -> FreeParameters:
    """All nuisances that the residual channels of a log call for; `shapes` (n, k) are those of the cells."""
    found: dict[str, tuple[Array, float]] = {}
    for name, (change, step, deviation) in _changes(clean, known).items():
        moved = channel_residuals(change(clean), grid, frame, model).values - base.values
        found[name] = (moved / step, deviation)
    found |= _wind(grid, frame, base) | _offsets(clean, grid, base, known.day_known)
    found |= _earth(clean, grid, frame, base)
    found |= _rounding(clean, grid, frame, model, base, known, shapes)
    columns = np.stack([column for column, _ in found.values()], axis=2)
    return FreeParameters(tuple(found), columns, np.array([deviation for _, deviation in found.values()]))


def _rounding(
    clean: Track,
    grid: Grid,
    frame: Frame,
    model: Replay | None,
    base: ChannelResiduals,
    known: AnalysisSetting,
    shapes: Array,
) -> dict[str, tuple[Array, float]]:
    """A coarse step rounds a steady pressure the same way for long: an error a phase of flight and a variable."""
    found: dict[str, tuple[Array, float]] = {}
    step = known.pressure_step
    for name in ("impact_pressure", "static_pressure") if step else ():
        moved = channel_residuals(_shifted(name, step)(clean), grid, frame, model).values - base.values
        for i, shape in enumerate(shapes.T):
            found[f"{name} rounding {i}"] = (moved * shape[:, None], float(1.0 / np.sqrt(12.0)))
    return found


def _changes(clean: Track, known: AnalysisSetting) -> Mapping[str, tuple[Change, float, float]]:
    changes: dict[str, tuple[Change, float, float]] = {}
    basis = MODELS["inverse+"].basis(clean["impact_pressure"] / REFERENCE_PRESSURE)
    for i, name in enumerate(MODELS["inverse+"].parameter_names):
        changes[f"curve {name}"] = (_curved(basis[:, i], known.static_error), 0.01, CURVE_DEVIATION)
    wider = 1.0 if known.day_known else FOREIGN
    for name, deviation in ANGLE_BIAS.items():
        if name in clean:
            changes[f"{name} bias"] = (_shifted(name, 0.002), 0.002, wider * deviation)
    for name, deviation in ANGLE_SCALE.items():
        if name in clean:
            changes[f"{name} scale"] = (_scaled(name, 1.01), 0.01, wider * deviation)
    return changes


def without_curve(track: Track, sizes: Mapping[str, float], known: AnalysisSetting) -> Track:
    """A track with an error curve of these sizes taken out; other names are passed over."""
    measured = track["impact_pressure"]
    basis = MODELS["inverse+"].basis(measured / REFERENCE_PRESSURE)
    names = MODELS["inverse+"].parameter_names
    share = sum((sizes.get(f"curve {n}", 0.0) * basis[:, i] for i, n in enumerate(names)), np.zeros(len(measured)))
    true = measured / (1.0 - np.clip(share, -MOST_ERROR, MOST_ERROR))
    corrected = {"impact_pressure": true}
    if known.static_error:
        corrected["static_pressure"] = track["static_pressure"] - (true - measured)
    return track.replaced(corrected)


def _curved(term: Array, static_error: bool) -> Change:
    """One hundredth of a term of the error curve, Δp = q_c − q_ci, which at a static source the pressure shows
    too."""

    def change(track: Track) -> Track:
        error = 0.01 * term * track["impact_pressure"]
        changed = {"impact_pressure": track["impact_pressure"] - error}
        return track.replaced(
            changed | ({"static_pressure": track["static_pressure"] + error} if static_error else {})
        )

    return change


def _scaled(name: str, factor: float) -> Change:
    return lambda track: track.replaced({name: track[name] * factor})


def _shifted(name: str, step: float) -> Change:
    return lambda track: track.replaced({name: track[name] + step})


def _wind(grid: Grid, frame: Frame, base: ChannelResiduals) -> dict[str, tuple[Array, float]]:
    found = {}
    for i, (name, deviation) in enumerate(zip(("north", "east", "down"), WIND_DEVIATION, strict=True)):
        toward = np.zeros((len(grid), 3))
        toward[:, i] = 1.0
        found[f"wind {name}"] = (in_triangle(toward, frame, base), deviation)
    return {name: pair for name, pair in found.items() if pair[0].any()}


def in_triangle(wind: Array, frame: Frame, base: ChannelResiduals) -> Array:
    """What a wind toward north, east, down [m/s], (n, 3), adds to the residuals, (n, c)."""
    column = np.zeros_like(base.values)
    down = "airspeed_down" in base.names
    parts = frame.turned(wind, down)
    for i, name in enumerate(("airspeed_along", "airspeed_across", "airspeed_down")[: parts.shape[1]]):
        column[:, base.names.index(name)] = parts[:, i]
    return column


def _offsets(clean: Track, grid: Grid, base: ChannelResiduals, day_known: bool) -> dict[str, tuple[Array, float]]:
    found = {}
    for name, deviation in (OFFSETS | (REPORTED if day_known else {})).items():
        if name in base.names:
            found[f"{name} offset"] = (_in_channel(base, name, np.ones(len(grid))), deviation)
    if "altitude" in clean:
        height = grid.smooth(clean["altitude"])
        for name, deviation in WITH_HEIGHT.items():
            if name in base.names:
                found[f"{name} lapse"] = (_in_channel(base, name, height - height.mean()), deviation)
    return found


def _earth(clean: Track, grid: Grid, frame: Frame, base: ChannelResiduals) -> dict[str, tuple[Array, float]]:
    """Coriolis acceleration: the latitude's sine acts in the horizontal, its cosine in the vertical."""
    if "acceleration_forward" not in base.names:
        return {}
    north, east = grid.smooth(clean["velocity_north"]), grid.smooth(clean["velocity_east"])
    down = "acceleration_down" in base.names
    turning = np.stack([-east, north, np.zeros_like(east)], axis=1)
    lifting = np.stack([np.zeros_like(east), np.zeros_like(east), -east], axis=1)
    found = {}
    for name, vector in (("earth turning", turning), ("earth lifting", lifting)):
        column = np.zeros_like(base.values)
        parts = frame.turned(vector, down)
        for i, axis in enumerate(("forward", "right", "down")[: parts.shape[1]]):
            column[:, base.names.index(f"acceleration_{axis}")] = np.where(grid.first, 0.0, parts[:, i])
        found[name] = (column, EARTH_RATE)
    return {name: pair for name, pair in found.items() if pair[0].any()}


def _in_channel(base: ChannelResiduals, name: str, values: Array) -> Array:
    column = np.zeros_like(base.values)
    column[:, base.names.index(name)] = values
    return column
