"""A calibration as plain data, by the keys of the command line's contract."""

from typing import Any

from pitotbench.records.calibrated_flight import CalibratedFlight
from pitotbench.records.calibration import Calibration, Estimate, Share, WindEstimate
from pitotbench.show.assumptions import assumptions_json
from pitotbench.show.columns import json_rows
from pitotbench.show.curve_table import CURVE_COLUMNS, curve_points
from pitotbench.show.limit import AUTO, Limit, judgments_json
from pitotbench.show.model_probabilities import probabilities_of
from pitotbench.show.short_answer import short_answer_of
from pitotbench.units import KNOT


def calibration_json(result: Calibration, limit: Limit | str | None = AUTO) -> dict[str, Any]:
    """A calibration as plain data; the unit is in each key. `limit` as for `judgments`."""
    weighed, answer = probabilities_of(result), short_answer_of(result, "")
    return {
        "model": result.model,
        "parameters": [_estimate(parameter) for parameter in result.parameters],
        "wind": _wind(result.wind),
        "wind_speed_kt": answer.wind_kt,
        "wind_from_deg": answer.wind_from_deg,
        "curve": json_rows(CURVE_COLUMNS, curve_points(result.curve)),
        "error_location": result.error_location,
        **assumptions_json(result),
        "residual_two_sigma_kt": result.residual_two_sigma / KNOT,
        "samples": result.samples,
        "converged": result.converged,
        "warnings": list(result.warnings),
        "limits": judgments_json(result, limit),
        "shares": [_share(share) for share in result.shares],
        "diagnostics": {k: v for k, v in (result.diagnostics or {}).items() if k != "model_choice"},
        **({"model_choice": weighed} if weighed else {}),
    }


def flight_json(flight: CalibratedFlight) -> dict[str, Any]:
    """Which flight of its log a calibration is of, as plain data; nothing where a log alone holds one flight."""
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


def _estimate(found: Estimate) -> dict[str, Any]:
    return {"name": found.name, "value": found.value, "two_sigma": found.two_sigma}


def _wind(wind: WindEstimate) -> dict[str, Any]:
    down = wind.down
    return {
        "north_kt": wind.north.value / KNOT,
        "east_kt": wind.east.value / KNOT,
        "down_kt": down.value / KNOT if down else None,
        "north_two_sigma_kt": wind.north.two_sigma / KNOT,
        "east_two_sigma_kt": wind.east.two_sigma / KNOT,
        "down_two_sigma_kt": down.two_sigma / KNOT if down else None,
    }


def _share(share: Share) -> dict[str, Any]:
    return {
        "name": share.name,
        "value": share.estimate.value,
        "two_sigma": share.estimate.two_sigma,
        "curve_two_sigma_kt": share.curve / KNOT,
        "wind_two_sigma_kt": share.wind / KNOT,
    }
