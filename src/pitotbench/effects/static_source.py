"""Apply an error of the static source to the two recorded pressures."""

from pitotbench.effects.signals import Signals
from pitotbench.units import Pascal


def displaced(signals: Signals, error: Pascal) -> Signals:
    """Return the signals with the static pressure too high by an error [Pa], (n,).

    The total pressure stays, so the impact pressure (total minus static) falls by as much (Gracey 1980, NASA
    RP-1046, ch. 3).
    """
    return signals.with_channels(
        static_pressure=signals["static_pressure"] + error, impact_pressure=signals["impact_pressure"] - error
    )
