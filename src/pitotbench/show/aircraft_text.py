"""The check of an aircraft: for the terminal."""

from rich.console import Console

from pitotbench.records.attached import AircraftCheck, Attached, ManeuverCheck, StepResponse
from pitotbench.show.columns import Column, print_table
from pitotbench.show.quantity_words import words
from pitotbench.show.terminal import outside

MANEUVER_COLUMNS: tuple[Column[ManeuverCheck], ...] = (
    Column("maneuver", lambda m: m.maneuver, key="maneuver"),
    Column("speeds", lambda m: " ".join(f"{v:.0f}" for v in m.speeds_kt), "KCAS", key="speeds_kt"),
    Column("flown", lambda m: not m.failure, key="flown"),
    Column("time", lambda m: m.minutes, "min", ".1f", "minutes"),
    Column("on condition", lambda m: m.on_condition, "%", ".0%", "on_condition"),
)
STEP_COLUMNS: tuple[Column[StepResponse], ...] = (
    Column("step", lambda s: f"{words(s.quantity)} {s.step:+.0f} {s.unit}", key="step"),
    Column("at", lambda s: s.speed_kt, "KCAS", ".0f", "speed_kt"),
    Column("overshoot", lambda s: s.overshoot, "%", ".0%", "overshoot"),
    Column("settled to 10 %", lambda s: s.settled, "s", ".1f", "settled_s"),
)


def check_sentences(check: AircraftCheck) -> list[str]:
    """The check in sentences: whether it can be flown, its engines and speeds, the channels it lacks."""
    flown = [m for m in check.maneuvers if not m.failure]
    answer = f"{check.aircraft}: {len(flown)} of {len(check.maneuvers)} maneuvers can be flown."
    failures = [f"{m.maneuver} was not flown: {m.failure}" for m in check.maneuvers if m.failure]
    if check.attached is None:
        return [answer, "It has an autopilot of its own and flies the cards as they are written.", *failures]
    return [answer, *_found(check.attached), *failures]


def _found(found: Attached) -> list[str]:
    fastest = "Mach 0.7, to which the bench keeps, is" if found.mach_limited else "the maximum level speed is"
    count = {1: "one engine", 2: "two engines"}.get(found.engines, f"{found.engines} engines")
    sentences = [
        f"{found.mass_kg:,.0f} kg, {count} ({found.engine_kind}), thrust lag {found.engine_time_s:.1f} s.",
        f"At {found.altitude_ft:,.0f} ft with flaps up the stall speed is {found.stall_kt:.0f} KCAS, and {fastest} "
        f"{found.fastest_kt:.0f} KCAS: both found by flying the model.",
    ]
    if found.missing:
        sentences.append(
            f"Not recorded, because the model has no such channel: {', '.join(map(words, found.missing))}."
        )
    return sentences


def print_check(check: AircraftCheck, console: Console) -> None:
    """Print the check: sentences, maneuvers, step responses."""
    for number, sentence in enumerate(check_sentences(check)):
        console.print(outside(sentence, "" if number else "bold"))
    console.print()
    print_table(MANEUVER_COLUMNS, check.maneuvers, console, "In light turbulence")
    console.print()
    print_table(STEP_COLUMNS, check.steps, console, "Steps of the autopilot, in smooth air")
