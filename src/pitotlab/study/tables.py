"""The tables of a study, and what all answers take from them: means, spreads and orders."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from scipy.stats import t as student

from pitotbench import air
from pitotbench.records.case import DataSystem
from pitotbench.units import KNOT, Array
from pitotlab.study.measures import Measured
from pitotlab.study.reductions import NAMES


def airspeed_noise(airspeed_kt: Array, seconds: Array) -> float:
    """Return 2σ [kt] of white noise of the impact pressure at calibrated airspeeds [kt], each flown
    for a time [s].

    It is the noise of the default data system [Pa] times the slope of airspeed over impact
    pressure.
    """
    slope = air.calibrated_airspeed_slope(air.impact_pressure(airspeed_kt * KNOT))
    variance = np.average((DataSystem().impact_pressure_noise * slope) ** 2, weights=seconds)
    return 2.0 * float(np.sqrt(variance)) / KNOT


# The fit that a claim gets by default: the paper's method on all data of a standard card in smooth
# air.
DEFAULT_FIT: Mapping[str, object] = {
    "setting": "smooth",
    "variant": "standard",
    "das": "50/50",
    "model": "inverse+",
    "method": "paper",
    "form": "scalar",
    "wind": "constant",
    "down": True,
    "on_condition": False,
    "change": "none",
    "level": 0.0,
    "noise": 1.0,
    "gps_noise": 1.0,
    "given_down": False,
    "alone": False,
}
TABLES = ("fits", "flights", "density", "curves")


@dataclass(frozen=True, slots=True)
class Spread:
    """A number over seeds: mean, standard deviation (NaN for one seed), number of seeds."""

    mean: float
    deviation: float
    count: int

    @classmethod
    def of(cls, values: Iterable[float]) -> "Spread":
        """Return the spread of the finite values."""
        array = np.array([v for v in values if np.isfinite(v)], dtype=np.float64)
        deviation = float(np.std(array, ddof=1)) if len(array) > 1 else float("nan")
        return cls(float(np.mean(array)) if len(array) else float("nan"), deviation, len(array))

    @property
    def error(self) -> float:
        """Standard error of the mean; NaN for one seed."""
        return self.deviation / float(np.sqrt(max(self.count, 1)))

    @property
    def margin(self) -> float:
        """Half of the 95 % interval of the mean, by Student's t; NaN for one seed."""
        return float(student.ppf(0.975, max(self.count - 1, 1))) * self.error

    def with_margin(self, digits: int = 2) -> str:
        """Return the mean with its sign and, of more than one seed, half of its 95 % interval."""
        half = "" if np.isnan(self.margin) else f" ± {self.margin:.{digits}f} (95 % of the mean)"
        return signed(self.mean, digits) + half

    def text(self, digits: int = 2, unit: str = "") -> str:
        """Return mean ± standard deviation over seeds as text."""
        spread = "" if np.isnan(self.deviation) else f" ± {self.deviation:.{digits}f}"
        return f"{self.mean:.{digits}f}{spread}{unit}".replace("-", "−")


def mean(values: Iterable[float]) -> float:
    """Return the mean of the finite values; NaN for none."""
    return Spread.of(values).mean


def text(values: Iterable[float], digits: int = 2) -> str:
    """Return mean ± standard deviation of values over seeds as text."""
    return Spread.of(values).text(digits)


@dataclass(frozen=True, slots=True)
class StudyTables:
    """Tables of fits, flights, airspeed bins and curves; column names end in units."""

    fits: pd.DataFrame
    flights: pd.DataFrame
    density: pd.DataFrame
    curves: pd.DataFrame
    by_reduction: Mapping[tuple[object, ...], pd.DataFrame]  # fits of a maneuver, by seed

    @classmethod
    def of(cls, measured: Sequence[Measured]) -> "StudyTables":
        """Return the tables of all measurements."""
        return cls.of_tables(
            {n: pd.DataFrame([r for m in measured for r in getattr(m, n)]) for n in TABLES}
        )

    @classmethod
    def of_tables(cls, tables: Mapping[str, pd.DataFrame]) -> "StudyTables":
        """Return the record of tables given by name (`TABLES`)."""
        # Grouped once: fits are looked up thousands of times, and to filter each time takes longer
        # than the fits.
        groups = tables["fits"].groupby(["maneuver", *DEFAULT_FIT], sort=False)
        return cls(
            **tables,
            by_reduction={key: group.set_index("seed").sort_index() for key, group in groups},
        )

    @property
    def seeds(self) -> tuple[int, ...]:
        """Return the seeds flown."""
        return tuple(sorted(int(seed) for seed in self.flights["seed"].unique()))

    def fit(self, column: str, maneuver: str, **how: object) -> pd.Series:
        """Return a column of the fits of a maneuver by seed; `how` has the settings that differ
        from `DEFAULT_FIT`.

        Raises KeyError for a setting that is not in `DEFAULT_FIT`.
        """
        if unknown := set(how) - set(DEFAULT_FIT):
            raise KeyError(
                f"fits are chosen by {', '.join(DEFAULT_FIT)}; not by {', '.join(sorted(unknown))}"
            )
        found = self.by_reduction.get((maneuver, *{**DEFAULT_FIT, **how}.values()))
        return pd.Series(dtype=float) if found is None else found[column].astype(float)

    def residual(self, maneuver: str, **how: object) -> pd.Series:
        """Return 2σ of the residual [kt] by seed."""
        return self.fit("residual_two_sigma_kt", maneuver, **how)

    def bound(self, maneuver: str, **how: object) -> pd.Series:
        """Return the covering 2σ of the curve [kt] by seed."""
        return self.fit("two_sigma_kt", maneuver, method="covering", **how)

    def flight(
        self, column: str, maneuver: str, setting: str = "smooth", variant: str = "standard"
    ) -> pd.Series:
        """Return a column of the flights of a maneuver by seed."""
        chosen = _chosen(self.flights, maneuver, setting, variant)
        return chosen.set_index("seed")[column].astype(float).sort_index()

    def seconds(self, maneuver: str, variant: str = "standard") -> pd.DataFrame:
        """Return the seconds at each airspeed in smooth air, which are from one seed."""
        return _chosen(self.density, maneuver, "smooth", variant)


def _chosen(table: pd.DataFrame, maneuver: str, setting: str, variant: str) -> pd.DataFrame:
    wanted = {"maneuver": maneuver, "setting": setting, "variant": variant}
    return table[np.all([table[name] == value for name, value in wanted.items()], axis=0)]


def signed(value: float, digits: int = 1) -> str:
    """Return a number with its sign, as text for a sentence."""
    return f"{value:+.{digits}f}".replace("-", "−")


def span(values: Sequence[float], digits: int = 2) -> str:
    """Return the least and the largest of some numbers, as text for a sentence."""
    low, high = min(values), max(values)
    return f"{low:.{digits}f} to {high:.{digits}f}"


def ratio(one: pd.Series, other: pd.Series) -> Spread:
    """Return one over the other, seed by seed: of one flight, so that common errors cancel."""
    both = pd.concat([one, other], axis=1, keys=["one", "other"]).dropna()
    return Spread.of((both["one"] / both["other"]).to_numpy())


def percent_above(one: pd.Series, other: pd.Series) -> Spread:
    """Return the difference of one from the other in percent of the other, seed by seed."""
    found = ratio(one, other)
    return replace(found, mean=100.0 * (found.mean - 1.0), deviation=100.0 * found.deviation)


def rank_agreement(one: Array, other: Array) -> float:
    """Return Kendall's τ (1938) of two orders, 1 for the same; a tie counts as neither."""
    first, second = np.asarray(one, dtype=np.float64), np.asarray(other, dtype=np.float64)
    upper = np.triu_indices(len(first), 1)
    signs = np.sign(np.subtract.outer(first, first)) * np.sign(np.subtract.outer(second, second))
    return float(np.mean(signs[upper]))


def order(values: Mapping[str, float]) -> str:
    """Return the names of maneuvers by rising value."""
    return " < ".join(NAMES[m] for m in sorted(values, key=lambda m: values[m]))
