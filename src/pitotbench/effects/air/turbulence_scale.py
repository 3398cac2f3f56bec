"""Gusts of another length: the spectrum keeps its strength and moves in frequency.

Dryden's gust along the path is white noise through 1/(1 + L s/V). A lead-lag filter (1 + L s/V)/(1 + L' s/V) with a
gain of sqrt(L'/L) therefore gives exactly the gust of length L'. For the gusts across the path it is close.
"""

from collections.abc import Mapping

from pitotbench.effects.effect import AirEffect, Parameter
from pitotbench.effects.excitation import STEADY_LEGS
from pitotbench.effects.expression import Expression, difference, operation, product, quotient, size, total
from pitotbench.effects.overlay import Baseline, Overlay, WindTerm

NAME = "turbulence_scale"
LENGTH = 1750.0  # ft, of MIL-F-8785C above 2,000 ft
_CHANGE = size(NAME, "change")
_OLD, _NEW = size(NAME, "time_s"), size(NAME, "new_time_s")


def _component(name: str, value: Expression) -> str:
    return f'<fcs_function name="{name}"><function>{value}</function></fcs_function>'


def _filter(toward: str) -> str:
    return (
        f'<lead_lag_filter name="{size(NAME, toward)}"><input>atmosphere/turb-{toward}-fps</input>'
        f"<c1>{_OLD}</c1><c2>1.0</c2><c3>{_NEW}</c3><c4>1.0</c4></lead_lag_filter>"
    )


def _unless_off(value: Expression) -> Expression:
    """Return an expression that is exactly zero at zero change, where the filter would leave a rounding error."""
    return operation("ifthen", operation("eq", _CHANGE, 0.0), 0.0, value)


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    directions, grown = ("north", "east", "down"), total(1.0, _CHANGE)
    time = quotient(LENGTH, operation("max", 100.0, "velocities/vt-fps"))
    root = operation("sqrt", grown)
    return Overlay(
        sizes=((_CHANGE, sizes["change"]),),
        filters=(
            _component(_OLD, time),
            _component(_NEW, product(_OLD, grown)),
            *(_filter(toward) for toward in directions),
        ),
        winds=tuple(
            WindTerm(t, _unless_off(difference(product(root, size(NAME, t)), f"atmosphere/turb-{t}-fps")))
            for t in directions
        ),
    )


TURBULENCE_SCALE = AirEffect(
    name=NAME,
    family="air",
    acts_on="air",
    parameters=(Parameter("change", -0.6, -0.9, 3.0, "gusts longer by this share"),),
    source="MIL-F-8785C 1980, §3.7.2: Dryden spectra, 1,750 ft above 2,000 ft",
    what="The gusts are longer or shorter than the case says.",
    shows_in=STEADY_LEGS,  # long gusts need long legs
    build=_build,
)
