"""The linear model of an airplane: for the terminal and as plain data."""

from collections.abc import Mapping
from typing import Any

from pitotbench.records.linear_model import LinearModel, Mode
from pitotbench.show.columns import Column, json_rows, keyed
from pitotbench.show.tree import Heading, Node, Sentence, Table
from pitotbench.units import FOOT, KNOT, POUND, Array

MODE_COLUMNS: tuple[Column[Mode], ...] = (
    Column("mode", lambda m: m.name, key="name"),
    Column("", lambda m: m.eigenvalue.real, key="real_per_s"),
    Column("", lambda m: m.eigenvalue.imag, key="imaginary_per_s"),
    Column("natural frequency", lambda m: m.frequency, "rad/s", ".4g", "natural_frequency_radps"),
    Column("damping ratio", lambda m: m.damping, "", ".3f", "damping_ratio"),
    Column(
        "time to half",
        lambda m: m.half if m.half and m.half > 0.0 else None,
        "s",
        ".3g",
        "time_to_half_s",
    ),
    Column(
        "time to double",
        lambda m: -m.half if m.half and m.half < 0.0 else None,
        "s",
        ".3g",
        "time_to_double_s",
    ),
)


def linear_tree(found: LinearModel) -> list[Node]:
    """The linear model of an aircraft: its level flight, its modes, and the matrices A and B."""
    return [
        Sentence(
            f"{found.aircraft}: level flight at {found.calibrated_airspeed / KNOT:.1f} KCAS, "
            f"{found.height / FOOT:,.0f} ft, throttle {found.setting[0]:.2f}, "
            f"{found.mass / POUND:,.0f} lb, flaps up. Engines, propellers and flight controls are "
            "steady in the model; position and heading are left out."
        ),
        Sentence(
            "Wings are level, ailerons and rudder centered: this leaves a roll acceleration of "
            f"{found.roll_acceleration:.4f} rad/s²."
        ),
        Heading("Modes: the eigenvalues of A", (Table(MODE_COLUMNS, found.modes),)),
        _matrix("A", found, found.states, found.system_matrix),
        _matrix("B", found, found.inputs, found.input_matrix),
    ]


def _matrix(name: str, found: LinearModel, units: Mapping[str, str], matrix: Array) -> Node:
    """A matrix as a table: a row a state's rate, a column with the unit of a state or an input."""
    return Heading(
        f"{name}: the rate of each row's state, in its unit per second, by unit of each column",
        (
            Table(
                [
                    keyed("rate of", "rate of"),
                    *(keyed(each, each, unit, "z.4f") for each, unit in units.items()),
                ],
                [
                    {"rate of": state, **dict(zip(units, row, strict=True))}
                    for state, row in zip(found.states, matrix.tolist(), strict=True)
                ],
            ),
        ),
    )


def linear_json(found: LinearModel) -> dict[str, Any]:
    """The linear model as plain data: matrices as lists of rows, names and units in their order."""
    return {
        "aircraft": found.aircraft,
        "weight_lb": found.mass / POUND,
        "altitude_ft": found.height / FOOT,
        "calibrated_airspeed_kt": found.calibrated_airspeed / KNOT,
        "roll_acceleration_radps2": found.roll_acceleration,
        "states": list(found.states),
        "state_units": list(found.states.values()),
        "trim": found.trim.tolist(),
        "inputs": list(found.inputs),
        "input_units": list(found.inputs.values()),
        "setting": found.setting.tolist(),
        "A": found.system_matrix.tolist(),
        "B": found.input_matrix.tolist(),
        "modes": json_rows(MODE_COLUMNS, found.modes),
    }
