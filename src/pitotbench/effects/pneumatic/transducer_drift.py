"""A transducer whose zero drifts: with time since the start of the recording, or with temperature."""

from collections.abc import Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_HEIGHT, EARLY_AND_LATE
from pitotbench.effects.signals import Signals

MINUTE = 60.0  # s
SOURCE = "transducer data sheets: thermal zero shift some 0.01 % of full scale a kelvin, warm-up within an hour"


def _with_time(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    elapsed = (signals.time - signals.time[0]) / MINUTE
    return signals.with_channels(impact_pressure=signals["impact_pressure"] + sizes["rate_pa_per_min"] * elapsed)


def _with_temperature(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    # The drift counts from the first sample: a zero is usually taken before the flight.
    warmer = signals["total_temperature"] - signals["total_temperature"][0]
    return signals.with_channels(impact_pressure=signals["impact_pressure"] + sizes["shift_pa_per_k"] * warmer)


TIME_DRIFT = SensorEffect(
    name="time_drift",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("rate_pa_per_min", 3.0, -30.0, 30.0, "zero shift per minute since the first sample"),),
    source=SOURCE,
    what="The impact-pressure transducer drifts while it warms up.",
    shows_in=EARLY_AND_LATE,
    changes=("impact_pressure",),
    function=_with_time,
)

TEMPERATURE_DRIFT = SensorEffect(
    name="temperature_drift",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("shift_pa_per_k", 6.0, -60.0, 60.0, "zero shift per kelvin from the first sample"),),
    source=SOURCE,
    what="The impact-pressure transducer drifts with temperature.",
    shows_in=CHANGING_HEIGHT,
    changes=("impact_pressure",),
    needs=("total_temperature",),
    function=_with_temperature,
)
