"""The plan of a campaign: which cases are flown, expanded one by one."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import product
from math import prod
from typing import Any

from pitotbench.bench.campaign.draws import Draws
from pitotbench.bench.campaign.tasks import Calibrations, Task, cell_digest, content_key, options_of_models
from pitotbench.calibrate import CalibrationOptions
from pitotbench.calibrate.options import require_model
from pitotbench.pressure_error import PAPER_MODELS
from pitotbench.records.case import Case, DataSystem
from pitotbench.records.case_file import case_of_table, case_table
from pitotbench.records.errors import BadInputError
from pitotbench.sense import SYSTEMS, data_system
from pitotbench.simulate.hangar import find_aircraft
from pitotbench.simulate.maneuvers import maneuvers_named
from pitotbench.simulate.maneuvers.scaled_card import card_of

_MOST_DRAWN = 20  # flights whose figures are in the report


@dataclass(frozen=True, slots=True)
class CampaignPlan:
    """The cases of a campaign: rows × grid × draws × seeds, each with the same data systems and calibrations.

    base: table of the case that the others change, with units as in a case file.
    rows: changes that go together; grid: fields with their values, of which every combination is flown; draws:
    fields with random values. A field is a path such as `wind.speed_kt` or `effects.0.parameters.latency_s`.
    seeds: truth and sensor seeds; empty: those of the case, or a seed of its own for each draw.
    systems: data systems; empty: that of the case.
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
        drawn = [*self.draws.fields] if self.draws else []
        several = [name for name, values in self.grid.items() if len(values) > 1]
        return tuple(dict.fromkeys(name for name in (*listed, *several, *drawn) if name not in _NAMED))

    def tasks(self, log_format: str = "parquet", keep_logs: str = "all", report: bool = True) -> Iterator[Task]:
        """Give the tasks one by one; for a report, some of them draw their figures.

        Raises BadInputError or UnknownNameError for a case that cannot be.
        """
        first = self.seeds[0] if self.seeds else None
        distinct = bool(self.varied or self.draws)
        for number, cell in enumerate(self.cells()):
            systems = self.systems or (cell.das,)
            sensed = replace(cell, das=systems[0])
            digest = cell_digest(sensed, systems, self.calibrations)
            for seed in self.seeds or (None,):
                case = sensed if seed is None else replace(sensed, truth_seed=seed, sensor_seed=seed)
                key = content_key(digest, case)
                # Names by content, where maneuver and seed alone do not tell the flights apart.
                name = f"{case.maneuver}-seed{case.truth_seed}" + (f"-{key[:10]}" if distinct else "")
                drawn = report and seed == first and number < _MOST_DRAWN
                yield Task(name, key, case, systems, self.calibrations, log_format, keep_logs, draw=drawn)

    def cells(self) -> Iterator[Case]:
        """Give the cases one by one, with the seeds of the base, or with a seed of its own for each draw."""
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
        """Return the base with changed fields. Raises BadInputError for a field or a value that cannot be."""
        table = _copied(self.base)
        for path, value in changes.items():
            _put(table, path.split("."), value, path)
        return case_of_table(table)

    def check(self) -> None:
        """Raise BadInputError or UnknownNameError for a wrong field or value of any axis; fly nothing."""
        if not self.count:
            raise BadInputError("the plan holds no flight")
        middle = self.draws.middle() if self.draws else {}
        first = {name: values[0] for name, values in self.grid.items()}
        trials = [{**row, **first, **middle} for row in self.rows]
        trials += [{**trials[0], name: value} for name, values in self.grid.items() for value in values]
        for changes in trials:
            case = self.case(changes)
            card_of(case)


_NAMED = ("maneuver", "truth_seed", "sensor_seed")


def plan_of_names(
    base: Case, maneuvers: str, systems: str, models: str, seeds: range, options: CalibrationOptions
) -> CampaignPlan:
    """Return the plan of names as the command line takes them: one flight for each maneuver and seed.

    Raises UnknownNameError or BadInputError for a name that does not exist.
    """
    find_aircraft(base.aircraft)
    flown = maneuvers_named(maneuvers)
    sensed = systems_named(systems)
    fitted = names("model", models, PAPER_MODELS)
    for name in fitted:
        require_model(name)
    return CampaignPlan(
        case_table(base),
        grid={"maneuver": flown},
        seeds=seeds,
        systems=sensed,
        calibrations=options_of_models(fitted, options),
    )


def plan_tasks(
    base: Case, maneuvers: str, systems: str, models: str, seeds: int, options: CalibrationOptions
) -> list[Task]:
    """Return the tasks of a plan of names, with the seeds from 1 to `seeds`."""
    return list(plan_of_names(base, maneuvers, systems, models, range(1, seeds + 1), options).tasks())


def names(kind: str, text: str, known: Sequence[str]) -> tuple[str, ...]:
    """Return the names of a comma list, each once. `all` means all of `known`. Raises BadInputError for none."""
    chosen = tuple(part.strip() for part in text.split(",") if part.strip())
    if not chosen:
        raise BadInputError(f"no {kind} is named: give one, several with commas, or all ({', '.join(known)})")
    return tuple(known) if chosen == ("all",) else tuple(dict.fromkeys(chosen))


def systems_named(text: str) -> tuple[DataSystem, ...]:
    """Return the data systems of a comma list, each once."""
    # `20/1` and `20.0/1` are one system. One spelling gives it one name for its logs and one row of the results.
    systems = (data_system(name) for name in names("data system", text, list(SYSTEMS)))
    return tuple({system.label: system for system in systems}.values())


def seeds_of(text: str) -> range:
    """Return the seeds of `N`, which are 1 to N, or of `A-B`. Raises BadInputError for anything else."""
    return _seeds(text)


@lru_cache(maxsize=16)
def _seeds(text: str) -> range:
    first, dash, last = text.partition("-")
    try:
        found = range(int(first), int(last) + 1) if dash else range(1, int(first) + 1)
    except ValueError as error:
        raise BadInputError(f"seeds {text!r}: give a number or a range, such as 30 or 501-1000") from error
    if not found:
        raise BadInputError("--seeds: seeds count from 1, and the first of a range is not above the last")
    return found


def _copied(table: Mapping[str, Any]) -> dict[str, Any]:
    return {key: _copied_value(value) for key, value in table.items()}


def _copied_value(value: Any) -> Any:
    if isinstance(value, Mapping):
        return _copied(value)
    return [_copied_value(entry) for entry in value] if isinstance(value, list | tuple) else value


def _put(table: Any, path: Sequence[str], value: Any, whole: str) -> None:
    """Set the value at a path; a number of the path counts the entries of a list from 0."""
    name, *rest = path
    here: Any = name
    if isinstance(table, list):
        if not name.isdigit() or int(name) >= len(table):
            raise BadInputError(f"{whole}: the list has no entry {name!r}; it counts from 0 to {len(table) - 1}")
        here = int(name)
    elif not isinstance(table, dict):
        raise BadInputError(f"{whole}: {name!r} is below a value that is no table")
    if rest:
        if isinstance(table, dict):
            table.setdefault(here, {})
        _put(table[here], rest, value, whole)
        return
    if isinstance(table, dict):
        _drop_other_units(table, name)
    table[here] = value


def _drop_other_units(table: dict[str, Any], name: str) -> None:
    """Remove the same quantity in another unit, which the base may have been written in."""
    stem = name.rpartition("_")[0]
    for key in [key for key in table if stem and key != name and key.rpartition("_")[0] == stem]:
        if (
            isinstance(table[key], int | float | list)
            and not isinstance(table[key], bool)
            and stem not in ("truth", "sensor")
        ):
            del table[key]
