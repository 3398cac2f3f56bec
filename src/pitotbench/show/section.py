"""One part of a report: a maneuver as one data system saw it, in words and pictures."""

from collections.abc import Mapping
from html import escape

import numpy as np

from pitotbench.records.calibration import Calibration
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.show.curves import calibration_figure
from pitotbench.show.flights import flight_figure
from pitotbench.show.tables import curve_html
from pitotbench.units import DEGREE, KNOT, MetersPerSecond


def flight_section(
    flight: Flight,
    system: str,
    results: Mapping[str, Calibration],
    truth: Mapping[str, MetersPerSecond],
    first: bool,
) -> str:
    """The HTML of a section; the flight itself is drawn only for the `first` data system of a maneuver."""
    title = f"{flight.case.maneuver.replace('_', ' ').title()}, {system} Hz"
    main = next(iter(results.values()))
    flown = f"<h3>As flown</h3><figure>{flight_figure(flight)}</figure>" if first else ""
    return (
        f'<section id="{anchor(flight.case.maneuver, system)}"><h2>{escape(title)}</h2>{flown}'
        f"{words(main, system)}<figure>{calibration_figure(results, truth)}</figure>{curve_html(main)}</section>"
    )


def log_section(name: str, log: FlightLog, result: Calibration) -> str:
    """The HTML of a section for a measured log, of which nobody knows the truth."""
    rows = f"<p>{len(log):,} rows read, {result.samples:,} used.</p>"
    return (
        f"<section><h2>{escape(name)}</h2>{rows}{words(result, '')}"
        f"<figure>{calibration_figure({result.model: result})}</figure>{curve_html(result)}</section>"
    )


def anchor(maneuver: str, system: str) -> str:
    """The id of a section."""
    return f"{maneuver}-{system.replace('/', '-')}"


def words(result: Calibration, system: str) -> str:
    """The answer in plain sentences: correction at three speeds, wind, the two kinds of 2σ, warnings."""
    curve = result.curve
    picks = np.linspace(0, len(curve.correction) - 1, 3).astype(int)
    corrections = "; ".join(
        f"{curve.correction[i] / KNOT:+.2f} ± {curve.two_sigma[i] / KNOT:.2f} kt at "
        f"{curve.indicated_airspeed[i] / KNOT:.0f} KIAS"
        for i in picks
    )
    north, east = result.wind.north, result.wind.east
    speed = float(np.hypot(north.value, east.value)) / KNOT
    blows_from = float(np.arctan2(-east.value, -north.value) / DEGREE) % 360.0
    text = (
        f"<p><b>{escape(result.model)}{f' on {system} Hz' if system else ''}:</b> add {corrections} (± is 2σ). "
        f"Wind {speed:.1f} kt from {blows_from:.0f}°, 2σ {north.two_sigma / KNOT:.2f} kt north and "
        f"{east.two_sigma / KNOT:.2f} kt east. The residual's 2σ, the figure that the literature quotes, is "
        f"{result.residual_two_sigma / KNOT:.2f} kt; it says how noisy the air and the sensors were, not how well "
        f"the curve is known.</p>"
    )
    notes = "".join(f"<li>{escape(warning)}</li>" for warning in result.warnings)
    return text + (f'<ul class="warn">{notes}</ul>' if notes else "")
