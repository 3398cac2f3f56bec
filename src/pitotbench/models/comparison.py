"""Compare two versions of an airplane's file: what changed in flight, by channel, phase and term.

The old file flies the card once, in light turbulence. Both files are then put into its states on
the force meter, with the surfaces and throttles of the old one. Nothing is random there: equal
files give equal numbers. Each difference of the files is put alone into the old one, which gives
its own part of the change.
"""

import re
import shutil
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench.effects.overlay import Baseline
from pitotbench.effects.own_terms import terms_of
from pitotbench.models.coefficients import coefficient, coefficient_units, values_of
from pitotbench.models.file_edits import Edit, apply_edits, content, edits_between, token
from pitotbench.models.performance import find_main_figures
from pitotbench.records import BadInputError
from pitotbench.records.case import Case
from pitotbench.records.comparison import ChannelChange, FlownChange, ModelComparison, TermChange
from pitotbench.records.flight import Flight
from pitotbench.records.maneuver import CHANNELS
from pitotbench.records.motion import CONTROLS, ModelForces, Motion
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.aircraft_files import SimulationError, parse_xml, read_record
from pitotbench.simulation.aircraft_import import aircraft_name, import_aircraft
from pitotbench.simulation.autopilot.autopilot_file import open_all_tanks
from pitotbench.simulation.baseline import read_baseline
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.sortie import fly
from pitotbench.simulation.unit_forces import measure_forces
from pitotbench.units import Array

STEP = 0.5  # s between the states
SAME = 1e-5  # share of a channel below which a change is rounding
ALIKE = 0.02  # share of a change that one factor of the channel may leave at most
MOST_UNEXPLAINED = 0.05  # share of the whole change that the terms may miss before it is reported
ALONE, TOGETHER = "", "several parts that do not load one by one"
OTHERS = ("thrust", "power", "weight", "center of gravity", "I_xx", "I_yy", "I_zz", "I_xz")
UNITS = dict(
    zip(
        (*CHANNELS, *OTHERS),
        (*["lb"] * 3, *["lb ft"] * 3, "lb", "hp", "lb", "in aft", *["slug ft²"] * 4),
        strict=True,
    )
)


def compare_models(
    old: str, new: str, card: str = "diagnostic", say: Callable[[str], None] = lambda text: None
) -> ModelComparison:
    """Return what changed in flight between two JSBSim files, given by their paths.

    `card` names the maneuver that the old one flies. `say` is called with each line of progress.
    Raises UnknownNameError, BadInputError or SimulationError where a file is not taken, the old one
    cannot be flown, or the new one cannot be put into the states of that flight.
    """
    with TemporaryDirectory(prefix="pitotbench-") as scratch:
        shelf = Path(scratch)
        folders = [_imported(shelf / side, path) for side, path in (("old", old), ("new", new))]
        edits = edits_between(*folders)
        if not edits:
            return ModelComparison(old, new, card, np.empty(0), {}, (), (), ())
        say(f"fly {card} with {old}")
        base = find_aircraft(old)
        motion, phase = _motion(fly(Case(aircraft=old, maneuver=card)))
        baselines = [read_baseline(folder) for folder in folders]
        meter = _Meter(
            shelf, base, motion, _functions(baselines), _defined(base) | _defined(folders[1])
        )
        before = meter.forces((), "old")
        say(f"put {len(edits)} differences of the files into its states")
        terms, refused = [], []
        for edit in edits:
            try:
                terms.append(
                    _term(edit, before, meter.forces((edit,), edit.part), meter, baselines)
                )
            except SimulationError:
                refused.append(edit)
        after = meter.forces(edits, "new")
        if refused:
            # What the refused parts read may be a part that is new.
            group = [edit for edit in edits if edit in refused or edit.old is None]
            try:
                change = _changes(before, meter.forces(group, TOGETHER), motion)
            except SimulationError:
                group, change = edits, _changes(before, after, motion)
            terms = [term for term in terms if term.part not in {edit.part for edit in group}]
            parts = ", ".join(edit.part for edit in group)
            terms.append(
                TermChange(TOGETHER, parts, "", None, None, tuple(_whole(change, before, motion)))
            )
        traces = _changes(before, after, motion)
        channels = tuple(_whole(traces, before, motion))
        located = tuple(_located(traces, before, motion, phase))
        terms.sort(key=lambda t: -t.effects[0].share if t.effects else 0.0)
        flown: tuple[FlownChange, ...] = ()
        if channels:
            say("find the steady flight of both")
            flown = tuple(_flown(old, new))
        return ModelComparison(
            old,
            new,
            card,
            motion.time,
            traces,
            channels,
            located,
            tuple(terms),
            tuple(_remarks(channels, terms)),
            flown,
        )


def _flown(old: str, new: str) -> Iterator[FlownChange]:
    """Yield the figures of steady flight that both airplanes have."""
    try:
        before, after = find_main_figures(old), find_main_figures(new)
    except (BadInputError, SimulationError):
        return  # one without a trimmed stall is compared by its forces alone
    known = {(each.name, each.condition): each.model for each in after.figures}
    for each in before.figures:
        if (value := known.get((each.name, each.condition))) is not None:
            yield FlownChange(each.name, each.condition, each.unit, each.model, value)


def _imported(folder: Path, path: str) -> Path:
    source = Path(path)
    if not source.exists():
        raise BadInputError(f"{path}: no such aircraft file")
    place = folder / aircraft_name(source)
    place.mkdir(parents=True)
    import_aircraft(source, place)
    return place


@dataclass(slots=True)
class _Meter:
    """The force meter along a motion, for the aircraft in a folder with some differences."""

    shelf: Path
    base: Path
    motion: Motion
    names: frozenset[str]
    defined: frozenset[str]
    count: int = 0

    def forces(self, edits: Sequence[Edit], name: str) -> ModelForces:
        """Return the forces with some differences.

        Raises SimulationError where JSBSim refuses them.
        """
        self.count += 1
        folder = self.shelf / str(self.count) / self.base.name
        shutil.copytree(self.base, folder)
        file = folder / f"{folder.name}.xml"
        tree = parse_xml(file)
        apply_edits(tree.getroot(), edits, folder)
        if read_record(self.base) is not None:
            open_all_tanks(tree.getroot())
        tree.write(file, encoding="utf-8", xml_declaration=True)
        _require_whole(folder, self.defined)
        plant = Plant.load_folder(name, folder, at_once=True)
        return measure_forces(plant, self.motion, self.names)


def _defined(folder: Path) -> frozenset[str]:
    """Return the properties that an aircraft's functions, components and outputs define.

    Declarations define some as well.
    """
    found: set[str] = set()
    for element in _elements(folder):
        name = element.get("name", "")
        text = (
            (element.text or "").strip()
            if element.tag == "output" or element.get("value") is not None
            else ""
        )
        found |= {name, f"fcs/{name.lower().replace(' ', '-')}", text}
    return frozenset(found - {"", "fcs/"})


def _require_whole(folder: Path, known: frozenset[str]) -> None:
    """Raise SimulationError where an aircraft reads a property that only the other file defines.

    JSBSim ends the whole process at a property that nothing defines: such a mixture of two files is
    never loaded.
    """
    read = {
        (element.text or "").strip().lstrip("-")
        for element in _elements(folder)
        if element.tag in ("property", "independentVar", "input")
    }
    lost = sorted((read & known) - _defined(folder))
    if lost:
        raise SimulationError(f"{folder.name}: nothing defines {lost[0]}, which a function reads")


def _elements(folder: Path) -> Iterator[ET.Element]:
    for file in folder.rglob("*.xml"):
        yield from parse_xml(file).getroot().iter()


def _motion(flight: Flight) -> tuple[Motion, NDArray[np.str_]]:
    """Return a flight's states every `STEP`, and phases: labels without speed and heading."""
    every = round(STEP / float(np.median(np.diff(flight["time"]))))
    rows = np.arange(0, len(flight), every)
    absent = np.full(len(rows), np.nan)
    names = [
        name
        for name in Motion.__dataclass_fields__
        if name not in ("temperature_offset", *CONTROLS)
    ]
    states: dict[str, Any] = {name: flight[name][rows] for name in names}
    states |= {name: flight[name][rows] if name in flight.channels else absent for name in CONTROLS}
    return Motion(**states), np.array(
        [re.split(r" [\d.]+ kt", str(label))[0] for label in flight.segment[rows]]
    )


def _functions(baselines: Sequence[Baseline]) -> frozenset[str]:
    return frozenset(
        function.name for baseline in baselines for function in baseline.functions if function.name
    )


def _channels(forces: ModelForces, motion: Motion) -> dict[str, Array]:
    """Return every channel of the forces, (n,) each, in its unit of `UNITS`."""
    x, y, z = forces.air[:, :3].T
    forward, down = np.cos(motion.angle_of_attack), np.sin(motion.angle_of_attack)
    wind = (-x * forward - z * down, y, x * down - z * forward)
    series = (
        *wind,
        *forces.air[:, 3:].T,
        forces.thrust,
        forces.power,
        forces.weight,
        forces.gravity_center,
    )
    return dict(zip(UNITS, (*series, *forces.inertia.T), strict=True))


def _scales(forces: ModelForces, motion: Motion) -> dict[str, float]:
    """Return the largest value of each channel; of the center of gravity the chord [in]."""
    largest = {
        name: float(np.max(np.abs(series))) for name, series in _channels(forces, motion).items()
    }
    return largest | {"center of gravity": 12.0 * forces.wing[2]}


def _changes(before: ModelForces, after: ModelForces, motion: Motion) -> dict[str, Array]:
    """Return the change of each channel that changed, (n,) each."""
    old, new, scale = _channels(before, motion), _channels(after, motion), _scales(before, motion)
    changed_values = {name: new[name] - old[name] for name in old}
    smallest = {name: SAME * (scale[name] or float(np.max(np.abs(new[name])))) for name in old}
    return {
        name: change
        for name, change in changed_values.items()
        if np.max(np.abs(change)) > smallest[name]
    }


def _whole(
    changes: Mapping[str, Array], before: ModelForces, motion: Motion
) -> list[ChannelChange]:
    """Return the change of each channel over the whole motion, the largest share first."""
    everywhere = np.full(len(motion.time), ALONE)
    channels = _channels(before, motion)
    found = (
        replace(each, growth=_growth(channels[each.channel], changes[each.channel]))
        for each in _located(changes, before, motion, everywhere)
    )
    return sorted(found, key=lambda each: -each.share)


def _growth(old: Array, change: Array) -> float | None:
    """Return the share of a channel, (n,), that its change, (n,), is throughout, or None.

    None where the change is no constant share.
    """
    square = float(old @ old)
    share = float(old @ change) / square if square else 0.0
    left = change - share * old
    return share if share and left @ left <= ALIKE**2 * (change @ change) else None


def _located(
    changes: Mapping[str, Array], before: ModelForces, motion: Motion, phase: NDArray[np.str_]
) -> Iterator[ChannelChange]:
    """Yield the change of each channel in each phase, in the order of the flight."""
    scale, units = _scales(before, motion), coefficient_units(before, motion)
    for name, change in changes.items():
        for where in dict.fromkeys(phase.tolist()):
            own = change[phase == where]
            coefficient = own / units[name][phase == where] if name in units else None
            largest = float(np.max(np.abs(own)))
            yield ChannelChange(
                name,
                where,
                UNITS[name],
                float(np.sqrt(np.mean(own**2))),
                largest,
                largest / (scale[name] or largest or 1.0),
                None if coefficient is None else float(np.sqrt(np.mean(coefficient**2))),
            )


def _term(
    edit: Edit,
    before: ModelForces,
    after: ModelForces,
    meter: _Meter,
    baselines: Sequence[Baseline],
) -> TermChange:
    motion = meter.motion
    effects = tuple(_whole(_changes(before, after, motion), before, motion))
    function = edit.key[2] if edit.key[0] == "aerodynamics" else ""
    known = [
        term
        for baseline in baselines
        for term in terms_of(baseline)
        if term.function.name == function
    ]
    if not function or not known:
        leaf, unit, old, new = _only_number(edit)
        return TermChange(f"{edit.part} {leaf}".rstrip(), edit.part, unit, old, new, effects)
    term = known[-1]
    name, values = term.name, [values_of(term, forces, motion) for forces in (before, after)]
    (old, unit), (new, _) = (coefficient(term, f, motion) for f in (before, after))
    means = [None if each is None else float(np.mean(each)) for each in values]
    if old is not None and new is not None and abs(new - old) < 1e-6 * abs(old) and unit:
        # The slope is the same: what changed is the value at no angle or rate.
        (old, new), name, unit = means, f"{name}, its mean", ""
    return TermChange(name, edit.part, unit, old, new, effects)


def _only_number(edit: Edit) -> tuple[str, str, float | None, float | None]:
    """Return element, unit, old and new value of the only number of a part that differs.

    The element is "" where it is the part itself. Where no single number differs, the values are
    None.
    """
    if edit.old is None or edit.new is None:
        return "", "", None, None
    pair = [
        parse_xml(part).getroot() if isinstance(part, Path) else part
        for part in (edit.old, edit.new)
    ]
    leaves = [[each for each in part.iter() if (each.text or "").strip()] for part in pair]
    changed_values = [
        (a, b) for a, b in zip(*leaves, strict=False) if a.tag != b.tag or content(a) != content(b)
    ]
    if len(leaves[0]) != len(leaves[1]) or len(changed_values) != 1:
        return "", "", None, None
    old, new = (token((each.text or "").strip()) for each in changed_values[0])
    if isinstance(old, str) or isinstance(new, str):
        return "", "", None, None
    changed = changed_values[0][1]
    around = [each for each in pair[1].iter() if each is changed or changed in list(each)]
    unit = next((each.get("unit", "") for each in around[::-1] if each.get("unit")), "")
    return "" if changed is pair[1] else changed.tag, unit, old, new


def _remarks(channels: Sequence[ChannelChange], terms: Sequence[TermChange]) -> Iterator[str]:
    """Yield what the terms do not add up to: differences that act together."""
    for channel in channels:
        alone = [e.largest for term in terms for e in term.effects if e.channel == channel.channel]
        if not alone or max(alone) < MOST_UNEXPLAINED * channel.largest:
            yield f"The change of {channel.channel} is made by several differences together, by none alone."
        elif len(alone) > 1 and channel.largest > (1.0 + MOST_UNEXPLAINED) * sum(alone):
            yield f"The change of {channel.channel} is larger than those by each difference alone."
