"""Signals from formulas: a slow turn while slowing down, at any rate, with a pause if asked for."""

import numpy as np

from pitotbench import air
from pitotbench.effects import EFFECTS
from pitotbench.effects.response import Signals


def turning(seconds: float = 120.0, rate: float = 50.0, pause: float = 0.0) -> Signals:
    """Every channel that an effect may need, all of them moving; a pause [s] in time after half."""
    n = round(seconds * rate)
    time = 30.0 + np.arange(n) / rate
    time[n // 2 :] += pause
    static = 81000.0 + 100.0 * np.sin(time / 9.0)
    speed = 76.0 + 12.0 * np.cos(time / 15.0)
    temperature = 276.0 + 0.2 * np.sin(time / 7.0)
    mach = speed / air.sound_speed(temperature)
    wave = {
        name: 0.05 + 0.04 * np.sin(time / (2.0 + i))
        for i, name in enumerate(
            ("roll", "pitch", "roll_rate", "pitch_rate", "yaw_rate", "angle_of_attack", "sideslip")
        )
    }
    engine = {
        f"{name}_{side}": level * (1.0 + 0.2 * np.sin(time / 11.0))
        for name, level in (
            ("manifold_pressure", 9e4),
            ("propeller_speed", 270.0),
            ("throttle", 0.5),
        )
        for side in ("left", "right")
    }
    return Signals(
        time,
        {
            **wave,
            **engine,
            "heading": np.mod(time / 20.0, 2.0 * np.pi),
            "impact_pressure": np.asarray(air.impact_pressure_from_mach(mach, static)),
            "static_pressure": static,
            "total_temperature": np.asarray(air.total_temperature(temperature, mach)),
            "velocity_north": speed * np.cos(time / 20.0) + 5.0,
            "velocity_east": speed * np.sin(time / 20.0) - 6.0,
            "velocity_down": 0.3 * np.sin(time / 3.0),
            "altitude": 1830.0 + 10.0 * np.sin(time / 9.0),
            "specific_force_x": 0.5 + 0.3 * np.sin(time / 4.0),
            "specific_force_y": 0.1 * np.sin(time / 4.0),
            "specific_force_z": -9.8 + 0.3 * np.sin(time / 5.0),
        },
    )


def applied(name: str, signals: Signals | None = None, **sizes: float) -> tuple[Signals, Signals]:
    """Signals without and with an effect."""
    signals = signals or turning()
    return signals, EFFECTS[name].apply(signals, sizes)
