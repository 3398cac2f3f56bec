"""The assumptions of a bound in words: accuracies that no residual shows, and a zero offset that is corrected."""

from typing import Any

from pitotbench.records.calibration import Assumption, Calibration

_WORDS = {
    "temperature_k": ("temperature", "K"),
    "recovery_factor": ("recovery factor", ""),
    "static_pressure_pa": ("static pressure", "Pa"),
    "impact_pressure_zero_pa": ("zero of the impact pressure", "Pa"),
    "velocity_mps": ("GPS velocity", "m/s"),
    "latency_s": ("GPS latency", "s"),
}
_SOURCES = {
    "usual": "usual",
    "header": "stated by the log",
    "stated": "stated",
    "standard day": "standard day",
    "method": "method",
}


def assumption_lines(result: Calibration) -> list[str]:
    """Return the accuracies on which the bounds depend, and the zero offset that the correction takes out."""
    return [line for line in (_accuracies(result), _zero(result)) if line]


def _accuracies(result: Calibration) -> str:
    stated = [each for each in result.assumptions if each.two_sigma > 0.0]
    exact = [each for each in result.assumptions if each.two_sigma == 0.0]
    parts = [f"{_name(each)} ±{_sized(each)} ({_SOURCES[each.source]})" for each in stated]
    if exact:
        sources = dict.fromkeys(_SOURCES[each.source] for each in exact)
        parts.append(f"no constant error of {', '.join(map(_name, exact))} ({', '.join(sources)})")
    return f"The bounds assume these constant errors (2σ): {'; '.join(parts)}." if parts else ""


def _zero(result: Calibration) -> str:
    zero = result.impact_pressure_zero
    if zero is None:
        return ""
    return (
        "Add the correction to the raw reading: it takes out a zero offset of the impact pressure of "
        f"{zero.value:+.0f} ± {zero.two_sigma:.0f} Pa (2σ); Δp/q_c is the pressure error without it."
    )


def _name(each: Assumption) -> str:
    return _WORDS[each.name][0]


def _sized(each: Assumption) -> str:
    return f"{each.two_sigma:g} {_WORDS[each.name][1]}".rstrip()


def assumptions_json(result: Calibration) -> dict[str, Any]:
    """Return the same as plain data. The units are the suffixes of the names."""
    zero = result.impact_pressure_zero
    return {
        "assumptions": [
            {"name": each.name, "two_sigma": each.two_sigma, "source": each.source} for each in result.assumptions
        ],
        "impact_pressure_zero_pa": None if zero is None else {"value": zero.value, "two_sigma": zero.two_sigma},
    }
