"""What is known before a flight: the priors of the candidate, each with its unit and its source."""

from dataclasses import dataclass, field


def _prior(value: float, unit: str, usual: str, source: str) -> float:
    """A field with its unit, its usual range and its source."""
    found: float = field(default=value, metadata={"unit": unit, "usual": usual, "source": source})
    return found


@dataclass(frozen=True, slots=True)
class Priors:
    """Standard deviations (1σ) of the unknowns, and medians of the sizes of the noise.

    A size or a length has a log-normal prior: its median, and one standard deviation as a factor.
    A level falls off by the larger `calm_factor` below its median, so that smooth air stays smooth.
    """

    # The curve of the static source, Δp/q_c, over half the flown range of ln q_ci.
    level: float = _prior(
        0.05, "", "0.04 to 0.06", "light airplanes, +0.1 at 55 kt to -0.05 at 115"
    )
    slope: float = _prior(0.05, "", "0.02 to 0.06", "the same")
    departure: float = _prior(0.005, "", "0.002 to 0.02", "0.0005 to 0.02: RP-1046, a handbook")
    departure_factor: float = _prior(3.0, "", "2 to 4", "the same")
    departure_length: float = _prior(0.7, "half ranges", "0.5 to 1", "the same")
    # The curve of the total source, and the factor of the impact-pressure sensor.
    total_level: float = _prior(
        0.005, "", "0.005 to 0.01", "pitot tubes in straight flight, Gracey"
    )
    total_slope: float = _prior(0.002, "", "0.001 to 0.005", "the same")
    scale: float = _prior(0.005, "", "0.003 to 0.01", "an air-data system within its tolerance")
    unknown_scale: float = _prior(0.3, "", "0.1 to 0.5", "sensors that nobody calibrated")
    unknown_zero: float = _prior(50.0, "Pa", "20 to 100", "the same")
    unknown_share: float = _prior(0.05, "", "0.01 to 0.5", "share of such sensors among logs")
    # The wind and the clocks.
    wind: float = _prior(30.0, "m/s", "20 to 60", "a component at flying heights")
    shear: float = _prior(0.015, "1/s", "0.005 to 0.03", "a component over 300 m")
    latency: float = _prior(1.0, "s", "0.2 to 2", "0.5 to 1.1 s in four cockpits")
    height_latency: float = _prior(0.5, "s", "0.1 to 1", "the receiver's filters")
    jump: float = _prior(3.0, "m/s", "2 to 5", "a component of a front")
    jump_odds: float = _prior(0.3, "", "0.1 to 0.5", "of a front in a flight, before it is seen")
    jump_seconds: float = _prior(20.0, "s", "10 to 60", "that a front lasts")
    # The noise of the airspeed.
    gust: float = _prior(0.5, "m/s", "0.2 to 1.5", "light turbulence, MIL-F-8785C")
    gust_length: float = _prior(533.0, "m", "200 to 1000", "Dryden above 2,000 ft, MIL-F-8785C")
    slow_wind: float = _prior(0.4, "m/s", "0.2 to 1", "change of a wind within minutes")
    slow_time: float = _prior(300.0, "s", "100 to 1000", "the same")
    slow_shortest: float = _prior(60.0, "s", "40 to 120", "shortest period of the slow wind")
    white: float = _prior(0.1, "m/s", "0.02 to 0.3", "beside the noise of the pressure sensor")
    level_factor: float = _prior(4.0, "", "3 to 5", "of every level above its median")
    calm_factor: float = _prior(30.0, "", "10 to 100", "of every level below its median")
    slow_calm_factor: float = _prior(5.0, "", "3 to 30", "of the slow wind below its median")
    length_factor: float = _prior(2.5, "", "2 to 4", "of lengths and times")
