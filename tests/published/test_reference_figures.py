"""The model of the Navajo against its published figures (aircraft/navajo/reference.toml), flown."""

import pytest

from pitotbench.simulation.properties import HORSEPOWER
from pitotlab.reference_figures import (
    FLOWN,
    Figure,
    ReferenceRow,
    airborne,
    hold_pressure,
    published_figures,
    reference_table,
)

FIGURES = published_figures("navajo")


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: figure.name)
def test_the_model_flies_the_published_figure(figure: Figure) -> None:
    row = ReferenceRow(figure, FLOWN[figure.maneuver]("navajo", figure))
    assert figure.source
    assert figure.tolerance > 0.0
    assert row.within, (
        f"{figure.name}: {row.model:.1f} against {figure.value} {figure.unit} ({figure.source})"
    )


@pytest.mark.parametrize("pressure_inhg", [25.0, 35.0])
def test_power_at_constant_manifold_pressure_does_not_depend_on_height(
    pressure_inhg: float,
) -> None:
    powers = []
    for altitude_ft in (1000.0, 15000.0):
        plant = airborne("navajo", FIGURES[0], 150.0, altitude_ft)
        hold_pressure(plant, pressure_inhg)
        plant.run(20.0)
        powers.append(plant.get("power_left") / HORSEPOWER)
    assert powers[1] == pytest.approx(powers[0], rel=0.02)


def test_difference_and_tolerance_stand_in_one_unit(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [ReferenceRow(figure, figure.value - 0.5) for figure in FIGURES]
    monkeypatch.setattr("pitotlab.reference_figures.fly_reference", lambda aircraft: rows)
    for figure, line in zip(FIGURES, reference_table("navajo").splitlines()[2:], strict=True):
        difference, tolerance = (cell.strip() for cell in line.split("|")[4:6])
        assert difference.split(" ", 1)[1] == tolerance.split(" ", 1)[1]
        if figure.tolerance_unit != "%":
            assert difference == f"-0.5 {figure.tolerance_unit}"
    rows[0] = ReferenceRow(FIGURES[0], 1.05 * FIGURES[0].value)
    first = reference_table("navajo").splitlines()[2]
    assert "**no**" in first
    assert "+5.0 %" in first
