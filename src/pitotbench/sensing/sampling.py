"""The data systems, and the instants at which each samples a flight."""

import re
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pitotbench.catalog import Catalog, explain
from pitotbench.records import BadInputError
from pitotbench.records.case import USUAL_RATE, DataSystem
from pitotbench.timeline import gaps, interval, stretches
from pitotbench.units import Array, Booleans, Seconds

# The data systems of the source (Martos, Kiszely and Foster 2011, §II.C), and systems of any other
# rates. Where the noise levels come from: the source adds white noise to the dynamic pressure, "an
# order of magnitude higher than the specification sheet". Rosemount-class transducers are specified
# at 0.026 % of full scale (3σ). - Impact pressure: full scale 2 psi = 13,789.5 Pa (a 280 KCAS
# instrument). 0.026 % of it is 3.59 Pa at 3σ, so 1.195 Pa at 1σ; ten times that is 11.95 Pa: 12 Pa,
# which is 0.36 kt at 100 KCAS and 0.22 kt at 160 KCAS. - Static pressure: full scale 38 inHg =
# 128,683 Pa. 0.026 % is 33.5 Pa at 3σ, 11.2 Pa at 1σ: 10 Pa is the specification itself, not
# raised, since the source corrupts the dynamic pressure only. - Resolutions are those of 16-bit
# words over full scale: 0.2 Pa of 13,789.5 Pa, 1.5 Pa of about 103 kPa. - Velocity: 0.05 m/s (1σ)
# for an integrated IMU/GPS solution; 0.1 m/s for a receiver alone, which prints hundredths of a
# meter per second. Both are common in data sheets; the choice is ours, the source gives none.

INERTIAL_RATE = 10.0  # Hz, from which velocity counts as an integrated IMU/GPS solution

_HIGH_END = DataSystem()
_LOW_END = replace(_HIGH_END, velocity_noise=0.1, velocity_resolution=0.01)

SYSTEMS: Catalog[DataSystem] = Catalog(
    "data system",
    {
        "20/1": replace(_LOW_END, air_rate=20.0, gps_rate=1.0),
        "50/50": replace(_HIGH_END, air_rate=50.0, gps_rate=50.0),
        "100/100": replace(_HIGH_END, air_rate=100.0, gps_rate=100.0),
    },
)

_RATES = re.compile(r"\s*(\d+(?:\.\d+)?)\s*/\s*(\d+(?:\.\d+)?)\s*")


def data_system(text: str) -> DataSystem:
    """Return the data system of a name `A/G`: rates of air data over GPS [Hz], as `20/1`.

    The ratio need not be a whole number. A GPS below 10 Hz gets the noise of a receiver without
    inertial unit. Raises BadInputError for text that is not a pair of rates, and for rates that
    `require_rates` refuses.
    """
    if text in SYSTEMS:
        return SYSTEMS[text]
    rates = _RATES.fullmatch(text)
    if rates is None:
        raise BadInputError(
            f"{explain('data system', text, list(SYSTEMS))} Any rates in Hz will do, air data / "
            "GPS, such as 25/5."
        )
    air, gps = (float(rate) for rate in rates.groups())
    system = replace(_HIGH_END if gps >= INERTIAL_RATE else _LOW_END, air_rate=air, gps_rate=gps)
    require_rates(system, USUAL_RATE)
    return system


def require_rates(das: DataSystem, flight_rate: float) -> None:
    """Raise BadInputError unless 0 < GPS rate ≤ air-data rate ≤ rate of the flight [Hz]."""
    if not 0.0 < das.gps_rate <= das.air_rate:
        raise BadInputError(
            f"data system {das.label}: the GPS rate must be above 0 and not exceed the air-data "
            "rate; write air data first, for example 20/1"
        )
    # The rate of a flight is computed from its times, so it may be off by a rounding error.
    if das.air_rate > flight_rate * (1.0 + 1e-6):
        raise BadInputError(
            f"data system {das.label}: the air-data rate must not exceed the {flight_rate:g} Hz at "
            "which the flight is simulated; choose a lower one"
        )


def has_velocity_down(das: DataSystem) -> bool:
    """Return whether the system records velocity down.

    Where the system does not state it, only an integrated IMU/GPS does (the source, §II.C).
    """
    if das.vertical_velocity == "usual":
        return das.gps_rate >= INERTIAL_RATE
    return das.vertical_velocity == "recorded"


Indices = NDArray[np.intp]

_SLACK = 1e-6  # samples: instants this close to a sample are on it
_CLOCK_DECIMALS = 6  # the log's clock resolves a microsecond


@dataclass(frozen=True, slots=True)
class Instants:
    """Instants of a flight, (n,): the sample `below` or at each, and the next one's `weight`."""

    below: Indices
    weight: Array

    def of(self, channel: Array) -> Array:
        """Return a channel at these instants, (n,)."""
        # Most systems sample on the flight's samples: then values are copied exactly, without
        # arithmetic.
        if not self.weight.any():
            return channel[self.below]
        above = np.minimum(self.below + 1, len(channel) - 1)
        return channel[self.below] * (1.0 - self.weight) + channel[above] * self.weight


@dataclass(frozen=True, slots=True)
class Schedule:
    """When each row of a log, and each GPS fix, is sampled.

    `time` [s], `rows` and `air` have one entry a row: the stamp, the instant of the row, and the
    instant of its air data, which a latency makes earlier. `gps` has one entry a fix. `fix` (one a
    row) is the number of the latest fix, `fresh` whether that fix is new in this row.
    """

    time: Seconds
    rows: Instants
    air: Instants
    gps: Instants
    fix: Indices
    fresh: Booleans


def flight_rate(time: Seconds) -> float:
    """Return the sample rate of a flight [Hz]."""
    return 1.0 / interval(time)


def schedule(
    time: Seconds,
    air_rate: float,
    gps_rate: float,
    air_latency: float = 0.0,
    gps_latency: float = 0.0,
) -> Schedule:
    """Return when a system of rates [Hz] and latencies [s] samples a flight of given times [s].

    A flight is one or more stretches without gaps, because the set-up between speeds is not
    recorded. In each stretch the recorder starts anew: rows at start + k/air rate, fixes at start +
    j/GPS rate. Instants between two samples of the flight are interpolated linearly, so the rates
    need not divide one another. A latency may ask for an instant before a stretch: there its first
    sample is used.
    """
    rate = flight_rate(time)
    parts = [_Stretch(rows.start, rows.stop - 1, rate) for rows in stretches(time, gaps(time))]
    rows = [part.grid(air_rate) for part in parts]
    fixes = [part.grid(gps_rate) for part in parts]
    clock = [time[part.first] + row / rate for part, row in zip(parts, rows, strict=True)]
    # Fixes are numbered through the whole flight; `before` is the count of those in earlier
    # stretches.
    before = np.cumsum([0, *(len(fix) for fix in fixes)])
    fix = np.concatenate(
        [
            np.floor(row / rate * gps_rate + _SLACK).astype(np.intp) + n
            for row, n in zip(rows, before, strict=False)
        ]
    )
    return Schedule(
        time=np.round(np.concatenate(clock), _CLOCK_DECIMALS),
        rows=_instants([part.at(row) for part, row in zip(parts, rows, strict=True)]),
        air=_instants(
            [part.at(row - air_latency * rate) for part, row in zip(parts, rows, strict=True)]
        ),
        gps=_instants(
            [part.at(row - gps_latency * rate) for part, row in zip(parts, fixes, strict=True)]
        ),
        fix=fix,
        fresh=np.diff(fix, prepend=-1) != 0,
    )


@dataclass(frozen=True, slots=True)
class _Stretch:
    first: int
    last: int
    flight_rate: float

    def grid(self, rate: float) -> Array:
        """Return the sampling instants at a rate [Hz], in samples of the flight after the first."""
        step = self.flight_rate / rate
        count = int((self.last - self.first) / step + _SLACK) + 1
        return np.arange(count, dtype=np.float64) * step

    def at(self, position: Array) -> Array:
        """Return positions in the flight's arrays, kept within the stretch."""
        return self.first + np.clip(position, 0.0, self.last - self.first)


def _instants(positions: list[Array]) -> Instants:
    position = np.concatenate(positions)
    below = np.floor(position + _SLACK)
    weight = position - below
    return Instants(below.astype(np.intp), np.where(weight > _SLACK, weight, 0.0))
