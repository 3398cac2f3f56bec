"""The plan of a campaign: read from TOML, with grids and random draws, expanded case by case."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from math import prod
from pathlib import Path
from sys import maxsize
from typing import Any

from pitotbench.calibration.options import CalibrationOptions, options_from, require_model
from pitotbench.campaigns.draws import Draws
from pitotbench.campaigns.task import Calibrations, Task, cell_digest, content_key
from pitotbench.catalog import explain
from pitotbench.pressure_error import PAPER_MODELS
from pitotbench.records import BadInputError
from pitotbench.records.case import Case, DataSystem, rate_problem
from pitotbench.records.case_file import case_of_table, case_table
from pitotbench.records.intake import read_toml
from pitotbench.sensing.sampling import SYSTEMS, data_system
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.maneuvers import maneuvers_named
from pitotbench.simulation.sortie import card_of


@dataclass(frozen=True, slots=True)
class CampaignPlan:
    """The cases of a campaign, rows × grid × draws × seeds, with its systems and calibrations.

    `base`: table of the case that the others change, with units as in a case file. `rows`: changes
    that go together; `grid`: fields with their values, of which every combination is flown;
    `draws`: fields with random values. A field is a path such as `wind.speed_kt` or
    `effects.0.parameters.latency_s`. `seeds`: truth and sensor seeds; empty: those of the case, or
    a seed of its own for each draw. `systems`: data systems; empty: that of the case.
    """

    base: Mapping[str, Any] = field(default_factory=dict)
    rows: Sequence[Mapping[str, Any]] = ({},)
    grid: Mapping[str, Sequence[Any]] = field(default_factory=dict)
    draws: Draws | None = None
    seeds: range = range(0)
    systems: tuple[DataSystem, ...] = ()
    calibrations: Calibrations = (("", CalibrationOptions()),)

    @property
    def count(self) -> int:
        """The number of flights."""
        cells = len(self.rows) * prod(len(values) for values in self.grid.values())
        return cells * (self.draws.count if self.draws else 1) * max(len(self.seeds), 1)

    @property
    def varied(self) -> tuple[str, ...]:
        """The fields that differ between the flights, other than the maneuver and the seeds."""
        listed = [name for row in self.rows for name in row] if len(self.rows) > 1 else []
        several = [name for name, values in self.grid.items() if len(values) > 1]
        every = (*listed, *several, *self.drawn)
        return tuple(dict.fromkeys(name for name in every if name not in _NAMED))

    @property
    def drawn(self) -> tuple[str, ...]:
        """The fields with random values, over which a table of means averages."""
        return tuple(self.draws.fields) if self.draws else ()

    def tasks(
        self, log_format: str = "parquet", keep_logs: str = "all", draw: str = ""
    ) -> Iterator[Task]:
        """Give the tasks one by one.

        A flight alone has its page drawn in the units that the words of `draw` ask for; of many,
        `write_page` draws one.

        Raises BadInputError or UnknownNameError for a case that cannot be.
        """
        drawn = draw if self.count == 1 else ""
        distinct = bool(self.varied or self.draws)
        for cell in self.cells():
            systems = self.systems or (cell.das,)
            sensed = replace(cell, das=systems[0])
            digest = cell_digest(sensed, systems, self.calibrations)
            for seed in self.seeds or (None,):
                case = (
                    sensed if seed is None else replace(sensed, truth_seed=seed, sensor_seed=seed)
                )
                key = content_key(digest, case)
                # Names by content, where maneuver and seed alone do not distinguish the flights.
                name = f"{case.maneuver}-seed{case.truth_seed}" + (
                    f"-{key[:10]}" if distinct else ""
                )
                yield Task(
                    name, key, case, systems, self.calibrations, log_format, keep_logs, draw=drawn
                )

    def cells(self) -> Iterator[Case]:
        """Give the cases one by one, with the seeds of the base or, by draws, their own."""
        axes = [[(name, value) for value in values] for name, values in self.grid.items()]
        for row in self.rows:
            for cell in product(*axes):
                fixed = {**row, **dict(cell)}
                if self.draws is None:
                    yield self.case(fixed)
                    continue
                for seed, drawn in enumerate(self.draws.values(), start=1):
                    yield replace(self.case({**fixed, **drawn}), truth_seed=seed, sensor_seed=seed)

    def case(self, changes: Mapping[str, Any]) -> Case:
        """Return the base with changed fields.

        Raises BadInputError for a field or a value that cannot be.
        """
        table = _copied(self.base)
        for system in self.systems[:1]:  # the case's own data system is not flown
            rates = {"das.air_rate_hz": system.air_rate, "das.gps_rate_hz": system.gps_rate}
            changes = {**rates, **changes}
        for path, value in changes.items():
            _put(table, path.split("."), value, path)
        case = case_of_table(table)
        for system in self.systems:
            if problem := rate_problem(case.integration_rate, system.air_rate):
                raise BadInputError(f"integration_rate_hz: {problem}")
        return case

    def check(self) -> None:
        """Raise BadInputError or UnknownNameError for a wrong field or value of any axis.

        Nothing is flown.
        """
        if not 0 < self.count <= maxsize:
            raise BadInputError(
                f"the plan holds {'too many flights' if self.count else 'no flight'}"
            )
        middle = self.draws.middle() if self.draws else {}
        first = {name: values[0] for name, values in self.grid.items()}
        trials = [{**row, **first, **middle} for row in self.rows]
        trials += [
            {**trials[0], name: value} for name, values in self.grid.items() for value in values
        ]
        for changes in trials:
            case = self.case(changes)
            card_of(case)


_NAMED = ("maneuver", "truth_seed", "sensor_seed")


def plan_of_names(
    base: Case, maneuvers: str, systems: str, models: str, seeds: range, options: CalibrationOptions
) -> CampaignPlan:
    """Return the plan of names as the command line takes them, a flight for each maneuver and seed.

    Raises UnknownNameError or BadInputError for a name that does not exist.
    """
    find_aircraft(base.aircraft)
    flown = maneuvers_named(maneuvers)
    sensed = systems_named(systems)
    fitted = names("model", models, PAPER_MODELS)
    for name in fitted:
        require_model(name)
    calibrations = tuple(("", replace(options, model=model)) for model in fitted)
    return CampaignPlan(
        case_table(base),
        grid={"maneuver": flown},
        seeds=seeds,
        systems=sensed,
        calibrations=calibrations,
    )


def names(kind: str, text: str, known: Sequence[str]) -> tuple[str, ...]:
    """Return the names of a comma list, each once.

    `all` means all of `known`. Raises BadInputError for none.
    """
    chosen = tuple(part.strip() for part in text.split(",") if part.strip())
    if not chosen:
        raise BadInputError(
            f"no {kind} is named: give one, several with commas, or all ({', '.join(known)})"
        )
    return tuple(known) if chosen == ("all",) else tuple(dict.fromkeys(chosen))


def systems_named(text: str) -> tuple[DataSystem, ...]:
    """Return the data systems of a comma list, each once."""
    # `20/1` and `20.0/1` are one system. One spelling gives it one name for its logs and one row of
    # the results.
    systems = (data_system(name) for name in names("data system", text, list(SYSTEMS)))
    return tuple({system.label: system for system in systems}.values())


def seeds_of(text: str) -> range:
    """Return the seeds of `N`, which are 1 to N, or of `A-B`.

    Raises BadInputError for anything else.
    """
    first, dash, last = text.partition("-")
    try:
        found = range(int(first), int(last) + 1) if dash else range(1, int(first) + 1)
    except ValueError as error:
        raise BadInputError(
            f"seeds {text!r}: give a number or a range, such as 30 or 501-1000"
        ) from error
    if not found:
        raise BadInputError(
            "--seeds: seeds count from 1, and the first of a range is not above the last"
        )
    return found


def _copied(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _copied(entry) for key, entry in value.items()}
    return [_copied(entry) for entry in value] if isinstance(value, list | tuple) else value


def _put(table: Any, path: Sequence[str], value: Any, whole: str) -> None:
    """Set the value at a path; a number of the path counts the entries of a list from 0."""
    name, *deeper = path
    here: Any = name
    if isinstance(table, list):
        if not name.isdigit() or int(name) >= len(table):
            raise BadInputError(
                f"{whole}: the list has no entry {name!r}; it counts from 0 to {len(table) - 1}"
            )
        here = int(name)
    elif not isinstance(table, dict):
        raise BadInputError(f"{whole}: {name!r} is below a value that is no table")
    elif deeper:
        table.setdefault(here, {})
    else:
        _drop_other_units(table, name)
    if deeper:
        _put(table[here], deeper, value, whole)
    else:
        table[here] = value


def _drop_other_units(table: dict[str, Any], name: str) -> None:
    """Remove the same quantity in another unit, which the base may have been written in."""
    stem = "" if name in ("truth_seed", "sensor_seed") else name.rpartition("_")[0]
    for key in [key for key in table if stem and key != name and key.rpartition("_")[0] == stem]:
        if isinstance(table[key], int | float | list) and not isinstance(table[key], bool):
            del table[key]


_TABLES = ("case", "grid", "list", "draw", "calibrate", "das", "seeds")
_LABEL = "label"


def read_plan(path: Path) -> CampaignPlan:
    """Read a plan. `case` is a case as in a case file, or the path of one, relative to the plan.

    `grid`, `list` and `draw` change its fields, `das` is a list of data systems, `seeds` a number
    or a range and `calibrate` a table of options, or several with a `label` each. Raises
    BadInputError or UnknownNameError for anything that is wrong; the message begins with the name
    of the file.
    """
    stated = read_toml(path, "a plan")
    for name in stated:
        if name not in _TABLES:
            raise BadInputError(f"{path}: {explain('entry of a plan', name, list(_TABLES))}")
    try:
        plan = _plan(stated, path.parent)
        plan.check()
    except BadInputError as error:
        raise BadInputError(f"{path}: {error}") from error
    return plan


def _plan(stated: Mapping[str, Any], folder: Path) -> CampaignPlan:
    rows = stated.get("list", [{}])
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows) or not rows:
        raise BadInputError("list: give one [[list]] table or several")
    systems = stated.get("das")
    plan = CampaignPlan(
        base=_base(stated.get("case", {}), folder),
        rows=[_flat(row) for row in rows],
        grid={name: _values(name, value) for name, value in _table(stated, "grid").items()},
        draws=_draws(_table(stated, "draw")),
        seeds=seeds_of(str(stated["seeds"])) if "seeds" in stated else range(0),
        systems=systems_named(",".join(map(str, _list(systems)))) if systems else (),
        calibrations=_calibrations(stated.get("calibrate", {})),
    )
    if plan.systems and any(name.startswith("das.") for name in (*plan.varied, *plan.grid)):
        raise BadInputError("das: a list of data systems or fields das.…, not both")
    return plan


def _base(stated: Any, folder: Path) -> Mapping[str, Any]:
    if isinstance(stated, str):
        return read_toml(folder / stated, "a case file")
    if not isinstance(stated, dict):
        raise BadInputError("case: give a table, or the path of a case file")
    return stated


def _values(name: str, value: Any) -> Sequence[Any]:
    if name == "maneuver":
        return maneuvers_named(",".join(map(str, _list(value))))
    if isinstance(value, dict):
        raise BadInputError(
            f'grid: write a path in quotes, such as "wind.speed_kt" = [0, 15], not [grid.{name}]'
        )
    if not isinstance(value, list) or not value:
        raise BadInputError(f"grid: {name} needs a list of values")
    return value


def _draws(stated: Mapping[str, Any]) -> Draws | None:
    if not stated:
        return None
    settings = {name: stated[name] for name in ("count", "method", "seed") if name in stated}
    if "count" not in settings:
        raise BadInputError("draw: state the count, such as count = 200")
    return Draws(
        {name: spread for name, spread in stated.items() if name not in settings}, **settings
    )


def _calibrations(stated: Any) -> Calibrations:
    """Return every model of every table of options, with the table's label."""
    found = []
    for table in _list(stated):
        if not isinstance(table, dict):
            raise BadInputError(
                f"calibrate: give a table of options, [calibrate], or several, not {table!r}"
            )
        choices = {name: value for name, value in table.items() if name not in (_LABEL, "model")}
        options = options_from(choices)
        for model in _list(table.get("model", "inverse+")):
            if not isinstance(model, str):
                raise BadInputError(f"calibrate: model is a name or a list of names, not {model!r}")
            found.append((str(table.get(_LABEL, "")), replace(options, model=model)))
    marks = [(label, options.model) for label, options in found]
    if len(set(marks)) < len(marks):
        raise BadInputError(
            "calibrate: two calibrations have one label and one model; give each a label of its own"
        )
    return tuple(found)


def _table(stated: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    table = stated.get(name, {})
    if not isinstance(table, dict):
        raise BadInputError(f"{name}: give a table, [{name}]")
    return table


def _flat(row: Mapping[str, Any], path: str = "") -> dict[str, Any]:
    """Return a row with its tables as paths: `[list.wind] speed_kt` is `wind.speed_kt`."""
    found: dict[str, Any] = {}
    for name, value in row.items():
        found |= _flat(value, f"{path}{name}.") if isinstance(value, dict) else {path + name: value}
    return found


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]
