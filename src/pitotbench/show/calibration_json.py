"""A calibration as plain data, by the keys of the command line's contract."""

from collections.abc import Sequence
from dataclasses import asdict, fields, is_dataclass
from typing import Any

from pitotbench.records.calibration import (
    CalibratedFlight,
    Calibration,
    Estimate,
    Share,
    WindEstimate,
    WindowWind,
)
from pitotbench.records.outputs import file_name
from pitotbench.show.calibration import NamedFlight, findings_of
from pitotbench.show.columns import json_rows
from pitotbench.show.curve_rows import CURVE_COLUMNS, curve_points, points_json
from pitotbench.show.deliverables import settings_json
from pitotbench.show.handbook import handbook_json
from pitotbench.show.limits import AUTO, Limit, judgments_json
from pitotbench.units import KNOT


def flights_json(flights: Sequence[NamedFlight], limit: Limit | str | None = AUTO) -> object:
    """Return calibrated flights as the document, or list of them, of `pitotbench calibrate --json`.

    `limit` as for `judgments`.
    """
    documents = [
        {
            "log": file_name(each.file),
            "origin": "simulated" if each.flight.log.simulated else "measured",
            **calibration_json(each.flight.calibration, limit),
            **flight_json(each.flight),
            "fixed_speed": points_json(each.flight.calibration.points),
            **settings_json(each.settings),
        }
        for each in flights
    ]
    return documents[0] if len(documents) == 1 else documents


def calibration_json(result: Calibration, limit: Limit | str | None = AUTO) -> dict[str, Any]:
    """A calibration as plain data; the unit is in each key. `limit` as for `judgments`."""
    wind, zero = result.wind, result.impact_pressure_zero
    return {
        "model": result.model,
        "parameters": [asdict(each) for each in result.parameters],
        "wind": None if wind is None else _components(wind, "north", "east", "down"),
        "wind_speed_kt": None if wind is None else wind.speed_kt,
        "wind_from_deg": None if wind is None else wind.from_deg,
        "winds": [
            {"from_s": each.begin, "to_s": each.end, "altitude_m": each.altitude}
            | _components(each, "north", "east")
            for each in result.winds
        ],
        "curve": json_rows(CURVE_COLUMNS, curve_points(result.curve)),
        **handbook_json(result.curve),
        "error_location": result.error_location,
        "error_location_assumed": result.place_assumed,
        "temperature": result.day
        and {
            "standard_day_departure_k": result.day.departure,
            "five_kelvin_kt": result.day.by_five_kelvin / KNOT,
            "five_kelvin_when_slow_kt": result.day.by_slow_end / KNOT,
        },
        "usable": result.usable,
        # `units` is null where nothing else explains the factor.
        "scale": result.scale
        and asdict(result.scale) | {"units": list(result.scale.units) or None},
        "disagreements": [
            {"kind": each.kind, "words": each.words, "size_kt": each.size / KNOT}
            for each in result.disagreements
        ],
        "findings": [
            {
                "kind": each.kind or None,
                "words": each.words,
                "moves_kt": None if each.moves is None else each.moves / KNOT,
                "first": each.first,
                "usable": not each.fatal,
            }
            for each in findings_of(result)
        ],
        "one_sided": [
            {
                "indicated_airspeed_kt": [each.low / KNOT, each.high / KNOT],
                "track_deg": [each.begin, each.end],
            }
            for each in result.one_sided
        ],
        "parts": [{"from_s": begin, "to_s": end} for begin, end in result.parts],
        "left_out": list(result.left_out),
        "assumptions": [asdict(each) for each in result.assumptions],
        "priors": dict(result.priors),
        "stated": {
            each.name: each.value for each in result.provenance.choices if each.source == "stated"
        },
        "impact_pressure_zero_pa": None
        if zero is None
        else {"value": zero.value, "two_sigma": zero.two_sigma},
        "residual_two_sigma_kt": result.residual_two_sigma / KNOT,
        "samples": result.samples,
        "converged": result.converged,
        "warnings": list(result.warnings),
        "limits": judgments_json(result, limit),
        "shares": [_share(share) for share in result.shares],
        "diagnostics": _plain(result.diagnostics),
    }


def _plain(found: Any) -> dict[str, Any]:
    """Return a record as plain data, with those inside it in their places.

    What was not looked for has no key.
    """
    plain: dict[str, Any] = {}
    for each in fields(found):
        value = getattr(found, each.name)
        if is_dataclass(value):
            plain |= _plain(value)
        elif value is not None:
            plain[each.metadata.get("key", each.name)] = value
    return plain


def flight_json(flight: CalibratedFlight) -> dict[str, Any]:
    """Return which flight of its log a calibration is of, as plain data; {} for the only one."""
    if flight.count == 1 and flight.joined == 1:
        return {}
    return {
        "flight": {
            "number": flight.number,
            "of": flight.count,
            "from_s": float(flight.log.time[0]),
            "to_s": float(flight.log.time[-1]),
            "flights_of_the_curve": flight.joined,
        }
    }


def _components(wind: WindEstimate | WindowWind, *axes: str) -> dict[str, Any]:
    found: dict[str, Estimate | None] = {axis: getattr(wind, axis) for axis in axes}
    return {f"{axis}_kt": each.value / KNOT if each else None for axis, each in found.items()} | {
        f"{axis}_two_sigma_kt": each.two_sigma / KNOT if each else None
        for axis, each in found.items()
    }


def _share(share: Share) -> dict[str, Any]:
    return {
        "name": share.name,
        "value": share.estimate.value,
        "two_sigma": share.estimate.two_sigma,
        "curve_two_sigma_kt": share.curve / KNOT,
        "wind_two_sigma_kt": share.wind / KNOT,
    }
