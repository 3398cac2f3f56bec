"""Fly one case, record every channel, and return the truth of the flight."""

import struct
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from operator import call

import numpy as np

from pitotbench import air
from pitotbench.records import BadInputError
from pitotbench.records.aircraft import Attached
from pitotbench.records.case import Case, PressureErrorSpec, rate_problem
from pitotbench.records.flight import Flight
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.aircraft_files import read_record
from pitotbench.simulation.card import Card, override
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.simulation.modified import (
    ballast_overlay,
    load_fuel,
    mark_recording,
    overlay_of,
    patched_mass,
)
from pitotbench.simulation.pilot import PILOTS, TICK, Cockpit, Targets
from pitotbench.simulation.plant import Air, Plant
from pitotbench.simulation.properties import CHANNELS, PROPERTIES, Property
from pitotbench.units import KNOT, Array

# rows packed before they are transposed: 0.4 MB, which a processor's cache still holds
BLOCK = 1000
_ALWAYS = ("time", "mass")  # the mass divides the forces


def lines_of(names: Collection[str] | None) -> tuple[Property, ...]:
    """Return the lines of the table for some channels, with time and mass; all for None.

    Raises UnknownNameError for a name that is not in the table.
    """
    if names is None:
        return CHANNELS
    wanted = {PROPERTIES[name].name for name in (*_ALWAYS, *names)}
    return tuple(line for line in CHANNELS if line.name in wanted)


class Recorder:
    """A recorder of channels at every step of a plant, by default of all that it serves.

    Each step is one packed row, converted to SI block by block. Rows are packed into one buffer
    that is used again and again. This costs a quarter of the time of a bare step of JSBSim;
    assigning each row to an array costs a third.
    """

    def __init__(self, plant: Plant, channels: Sequence[Property] = ()) -> None:
        self._plant = plant
        channels = channels or plant.channels
        self._channels = channels
        self._factors = np.array([[line.factor] for line in channels])
        self._rows = np.empty((BLOCK, len(channels)))
        self._row_size = self._rows.strides[0]
        self._reads = [plant.getter(line.name)[0] for line in channels]
        self._pack = struct.Struct(f"{len(channels)}d").pack_into
        self._end = 0
        self._blocks: list[Array] = []

    def advance(self, steps: int) -> None:
        """Run the plant a number of steps and record after each.

        Raises SimulationError where JSBSim stops.
        """
        run, pack, rows, reads = self._plant.fdm.run, self._pack, self._rows.data, self._reads
        for count in (min(BLOCK, steps - done) for done in range(0, steps, BLOCK)):
            if self._end + count > BLOCK:
                self._flush()
            first = self._end
            for row in range(first, first + count):
                if not run():
                    raise self._plant.failure("JSBSim stopped")
                pack(rows, row * self._row_size, *map(call, reads))
            self._end = first + count

    def _flush(self) -> None:
        # The product with the factors transposes the rows: one pass gives contiguous channels in
        # SI.
        block = np.empty((len(self._channels), self._end))
        np.multiply(self._rows[: self._end].T, self._factors, out=block)
        finite = np.isfinite(block).all(axis=1)
        if not finite.all():
            bad = self._channels[int(np.argmin(finite))].name
            raise self._plant.failure(f"channel {bad!r} is not finite")
        self._blocks.append(block)
        self._end = 0

    def channels(self) -> dict[str, Array]:
        """Return the recorded channels by name [SI], one contiguous array (n,) a channel.

        Raises SimulationError where a value is not finite.
        """
        self._flush()
        found = {
            line.name: np.concatenate([block[i] for block in self._blocks])
            for i, line in enumerate(self._channels)
        }
        for line in self._channels:
            if line.per_mass:
                found[line.name] /= found["mass"]
        return found


# KCAS: the slowest and the fastest of the cards, which are the paper's.
CARD_SPEEDS = (100.0, 160.0)
ABOVE_STALL = 1.3  # times the stall speed: room for a bank of 45°
ABOVE_SLOWEST = 1.16  # times the slowest speed at which the autopilot's loops hold: the same room
SHARE = 0.76  # of the way from stall to maximum level speed: where 160 KCAS lies for the bench's own aircraft
READABLE = 280.0  # KCAS: the impact pressure of 285 is the end of the usual data system's range
SPREAD = 1.8  # largest ratio of the two speeds: more takes a jet minutes, and the paper's is 1.6


def card_of(case: Case) -> Card:
    """Return the card of a case, scaled to the speeds of its aircraft and overridden.

    Raises UnknownNameError for an unknown maneuver, aircraft or entry, BadInputError for a value of
    wrong shape.
    """
    return override(scaled_card(case.aircraft, case.maneuver), case.card)


def scaled_card(aircraft: str, maneuver: str) -> Card:
    """Return the card of a maneuver for an aircraft, scaled to its speeds.

    The bench's own aircraft fly the cards as they are written.
    """
    card = MANEUVERS[maneuver].card
    record = read_record(find_aircraft(aircraft))
    if record is None:
        return card
    slow, fast = card_speeds(record)
    share = (fast - slow) / (CARD_SPEEDS[1] - CARD_SPEEDS[0])
    speeds = tuple(round(slow + (v / KNOT - CARD_SPEEDS[0]) * share) * KNOT for v in card.speeds)
    return replace(
        card, speeds=speeds, airspeed_rate_limit=card.airspeed_rate_limit * min(1.0, share)
    )


def scaled_case(case: Case) -> Case:
    """Return a case with its true pressure error scaled to the speeds of its aircraft's card.

    The reference pressure becomes the impact pressure at the slowest speed of the cards; that of
    the default is at 100 KCAS. A case of the bench's own aircraft is returned as it is.
    """
    record = read_record(find_aircraft(case.aircraft))
    if record is None:
        return case
    reference = float(air.impact_pressure(card_speeds(record)[0] * KNOT))
    return replace(case, pressure_error=replace(case.pressure_error, reference_pressure=reference))


def with_usual_curve(case: Case) -> Case:
    """Return a case that states no error curve with the usual one at the speeds of its aircraft."""
    usual = PressureErrorSpec(location=case.pressure_error.location)
    return scaled_case(case) if case.pressure_error == usual else case


def speed_range(aircraft: str) -> tuple[float, float]:
    """Return the slowest and the fastest speed of the cards for an aircraft [m/s, calibrated]."""
    record = read_record(find_aircraft(aircraft))
    low, high = CARD_SPEEDS if record is None else card_speeds(record)
    return low * KNOT, high * KNOT


def card_speeds(record: Attached) -> tuple[float, float]:
    """Return the slowest and the fastest speed [kt] of the cards for an aircraft.

    Between stall and maximum level speed they lie as 100 and 160 KCAS do for the bench's own
    aircraft.
    """
    slow = max(ABOVE_STALL * record.stall_kt, ABOVE_SLOWEST * record.speed_kt[0])
    fast = record.stall_kt + SHARE * (record.fastest_kt - record.stall_kt)
    return slow, min(fast, SPREAD * slow, READABLE)


Progress = Callable[[float, str], None]


def fly(
    case: Case | str, progress: Progress | None = None, channels: Collection[str] | None = None
) -> Flight:
    """Fly a case, or the usual case of a maneuver by its name, and return the truth.

    The truth is recorded at the case's rate of integration. A case that states no error curve has
    the usual one at the speeds of its aircraft (see `with_usual_curve`), which `Flight.case` then
    holds.

    One case gives one flight, bit for bit, in any process on one platform. Time is the simulator's;
    it jumps where a set-up between speeds was flown unrecorded. `progress(seconds, label)` is
    called as each segment begins. `channels` names the channels to record with the time, by default
    all: to read one costs 1 % of a step. The flight itself does not depend on them. Channels that
    the aircraft does not serve are left out.

    Raises UnknownNameError for an unknown channel, aircraft, maneuver, card entry, turbulence,
    pilot or effect, BadInputError for impossible parameters of an effect or a rate that cannot be,
    SimulationError where the case cannot be flown.
    """
    # Names are looked up before the aircraft is loaded, so that a spelling mistake costs no time.
    case = Case(maneuver=case) if isinstance(case, str) else case
    recorded, maneuver = lines_of(channels), MANEUVERS[case.maneuver]
    if problem := rate_problem(case.integration_rate):
        raise BadInputError(problem)
    case = with_usual_curve(case)
    overlay = overlay_of(case)
    card = card_of(case)
    day = Air.of(case, overlay.temperature_offset)
    pilot = PILOTS[case.pilot]
    added = overlay + ballast_overlay(case.aircraft, case.ballast)
    plant = Plant.load(case.aircraft, case.integration_rate, added)
    load_fuel(plant, case.fuel)
    plant.start(case.altitude, card.speeds[0], air=day)
    # Truth seed: the same one drives the pilot and, through the air, the turbulence.
    targets = Targets(card.speeds[0], 0.0, case.altitude)
    cockpit = Cockpit(plant, card, targets, pilot(plant, case.truth_seed))
    recorder = Recorder(plant, [line for line in recorded if line in plant.channels])
    labels: list[str] = []  # one a recorded tick, as the flags are
    on_condition: list[bool] = []
    steps, announced = round(TICK / plant.time_step), ""
    # The card decides once a tick, the plant runs the steps of the tick.
    for _ in maneuver.fly(cockpit, card):
        if progress is not None and cockpit.label != announced:
            announced = cockpit.label
            progress(plant.get("time"), announced)
        cockpit.fly()
        # A tick is on condition where its first and its last state are.
        before = cockpit.on_condition()
        if cockpit.recorded and not labels:
            mark_recording(plant)
        (recorder if cockpit.recorded else plant).advance(steps)
        plant.check()
        cockpit.read_instruments()
        if cockpit.recorded:
            labels.append(cockpit.label)
            on_condition.append(before and cockpit.on_condition())
    segments, flags = np.array(labels, dtype=np.str_), np.array(on_condition, dtype=np.bool_)
    unlisted = patched_mass(case.aircraft)
    return Flight(
        case, recorder.channels(), np.repeat(segments, steps), np.repeat(flags, steps), unlisted
    )
