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
    assert row.within, f"{figure.name}: {row.model:.1f} against {figure.value} {figure.unit} ({figure.source})"


def test_every_figure_names_its_source() -> None:
    assert all(figure.source and figure.tolerance > 0.0 for figure in FIGURES)


@pytest.mark.parametrize("pressure_inhg", [25.0, 35.0])
def test_power_at_constant_manifold_pressure_does_not_depend_on_height(pressure_inhg: float) -> None:
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


def test_the_table_has_a_line_a_figure(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [ReferenceRow(figure, 1.05 * figure.value) for figure in FIGURES]
    monkeypatch.setattr("pitotlab.reference_figures.fly_reference", lambda aircraft: rows)
    lines = reference_table("navajo").splitlines()
    assert len(lines) == 2 + len(FIGURES)
    assert "**no**" in lines[2]
    assert "+5.0 %" in lines[2]
