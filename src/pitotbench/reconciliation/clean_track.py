"""The clean track: a track without noise and without gusts, on which signatures are computed.

A signature made of noisy signals would carry their noise. The residuals carry the same noise, so
that the two would correlate: a lag of this noise looks like a lag of the airplane. Noise in a
signature also counts as knowledge: on a circle at a constant airspeed, which cannot show a lag, one
of 0.25 s seemed to be worth 6σ. Therefore only the slow changes of a channel come from its own
sensor, and the quick ones from the sensors that feel them best (complementary filters: Higgins
1975). Those of the ground velocity come from the accelerometers, those of the two heights from the
vertical speed, those of the temperature from height and airspeed. Impact pressure is that of ground
velocity and wind. All else is smoothed by local parabolas (Savitzky and Golay 1964).
"""

from collections.abc import Mapping

import numpy as np

from pitotbench import air
from pitotbench.reconciliation.flight_path import (
    VELOCITY,
    WINDOW,
    air_velocity,
    complementary_filter,
    integrated,
    quick_velocity,
    smoothed,
    true_airspeed_along,
)
from pitotbench.reconciliation.track import (
    GPS_CHANNELS,
    Track,
    mach_number,
    outside_temperature,
)
from pitotbench.units import Array

# s, for a GPS without accelerometers: with 3 s its noise made a latency of 0.30 s come out as 0.24
# s.
GPS_WINDOW = 4.5
UNSMOOTHED = ("throttle_left", "throttle_right", "mass")  # steps of these channels are real


def clean_track(track: Track, wind: Array) -> Track:
    """Return the smoothed track; `wind` is toward north, east, down [m/s], (3,)."""
    changing = {name: values for name, values in track.channels.items() if name not in UNSMOOTHED}
    smooth = track.replaced(
        {name: smoothed(track, values, WINDOW) for name, values in changing.items()}
    )
    smooth = smooth.replaced({"static_pressure": _static_pressure(track, smooth)})
    velocity = quick_velocity(track)
    smooth = smooth.replaced(velocity)
    smooth = smooth.replaced(_impact_pressure(smooth, wind))
    smooth = smooth.replaced(_total_temperature(track, smooth))
    slow = [name for name in GPS_CHANNELS if name in track and name not in velocity]
    smooth = smooth.replaced({name: smoothed(track, track[name], GPS_WINDOW) for name in slow})
    return smooth.replaced(_altitude(track, smooth))


def _static_pressure(track: Track, smooth: Track) -> Array:
    """Static pressure with quick changes by the vertical speed and not by sensor noise."""
    down = smooth["velocity_down"] if "velocity_down" in smooth else air_velocity(smooth)[2]
    height = air.pressure_altitude(track["static_pressure"])
    return air.standard_pressure(complementary_filter(track, height, -integrated(track, down)))


def _altitude(track: Track, smooth: Track) -> Mapping[str, Array]:
    """Return GPS altitude with quick changes by vertical velocity; empty without one of them."""
    if "altitude" not in track or "velocity_down" not in track:
        return {}
    return {
        "altitude": complementary_filter(
            track, track["altitude"], -integrated(track, smooth["velocity_down"])
        )
    }


def _total_temperature(track: Track, smooth: Track) -> Mapping[str, Array]:
    """Return the total temperature with quick changes by height and airspeed, not by its sensor."""
    if "total_temperature" not in track:
        return {}
    standard = air.standard_temperature(air.pressure_altitude(smooth["static_pressure"]))
    expected = air.total_temperature(standard, mach_number(smooth))
    return {"total_temperature": complementary_filter(track, track["total_temperature"], expected)}


def _impact_pressure(track: Track, wind: Array) -> Mapping[str, Array]:
    """Impact pressure of the airspeed that ground velocity and wind give."""
    through = np.stack(air_velocity(track), axis=1)
    along = through / true_airspeed_along(track)[:, None]
    over = np.stack(
        [track[n] if n in track else through[:, i] + wind[i] for i, n in enumerate(VELOCITY)],
        axis=1,
    )
    speed = np.sum(along * (over - wind), axis=1)
    pressure = track["static_pressure"]
    temperature = outside_temperature(track, mach_number(track))
    return {
        "impact_pressure": air.impact_pressure_from_true_airspeed(
            np.maximum(speed, 1.0), pressure, temperature
        )
    }
