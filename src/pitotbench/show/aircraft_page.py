"""The check of an aircraft as a page: trim over airspeed, step responses, maneuvers."""

from matplotlib.axes import Axes

from pitotbench.records.attached import AircraftCheck, Attached, StepResponse
from pitotbench.show.aircraft_text import MANEUVER_COLUMNS, STEP_COLUMNS, check_sentences
from pitotbench.show.columns import html_table
from pitotbench.show.markup import render
from pitotbench.show.quantity_words import words
from pitotbench.show.style import BLUE, GREY, ORANGE, Panel, panel


def aircraft_page(check: AircraftCheck) -> str:
    """The HTML of the check of an aircraft."""
    panels = [] if check.attached is None else _trim_panels(check.attached)
    quantities = list(dict.fromkeys(step.quantity for step in check.steps))
    panels += [_step_panel([s for s in check.steps if s.quantity == quantity]) for quantity in quantities]
    return render(
        "aircraft.html",
        title=f"What can be flown with {check.aircraft}",
        sentences=check_sentences(check),
        panels=panels,
        maneuvers=html_table(MANEUVER_COLUMNS, check.maneuvers),
        steps=html_table(STEP_COLUMNS, check.steps),
    )


def _trim_panels(found: Attached) -> list[Panel]:
    def drawn(values: tuple[float, ...], label: str) -> Panel:
        return panel(label.split(" [")[0].capitalize(), lambda axes: _draw_trim(axes, found, values, label))

    return [
        drawn(tuple(100.0 * lever for lever in found.lever), "throttle in level flight [%]"),
        drawn(found.alpha_deg, "angle of attack in level flight [°]"),
    ]


def _draw_trim(axes: Axes, found: Attached, values: tuple[float, ...], label: str) -> None:
    axes.plot(found.speed_kt, values, "o-", color=BLUE, ms=3.5)
    axes.axvline(found.stall_kt, color=GREY, lw=1.0, ls="--", label="stall speed")
    axes.set(xlabel="calibrated airspeed [kt]", ylabel=label)


def _step_panel(steps: list[StepResponse]) -> Panel:
    def draw(axes: Axes) -> None:
        for step, color in zip(steps, (BLUE, ORANGE), strict=False):
            axes.plot(step.time, step.change, color=color, label=f"at {step.speed_kt:.0f} KCAS")
        axes.axhline(steps[0].step, color=GREY, lw=1.0, ls="--", label="asked for")
        axes.set(xlabel="time [s]", ylabel=f"change of {words(steps[0].quantity)} [{steps[0].unit}]")

    return panel(f"Step of {words(steps[0].quantity)}", draw)
