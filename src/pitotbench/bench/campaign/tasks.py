"""The tasks of a campaign. A task is one flight, sensed by every data system and calibrated with every model."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from pitotbench.calibrate import CalibrationOptions
from pitotbench.calibrate.options import require_model
from pitotbench.pressure_error import PAPER_MODELS
from pitotbench.records.case import Case
from pitotbench.records.errors import BadInputError
from pitotbench.sense import SYSTEMS, data_system
from pitotbench.simulate.hangar import find_aircraft
from pitotbench.simulate.maneuvers import maneuvers_named


@dataclass(frozen=True, slots=True)
class Task:
    """One flight, the data systems that sense it, the models that it is calibrated with, and its folder."""

    case: Case
    systems: tuple[str, ...]
    models: tuple[str, ...]
    options: CalibrationOptions
    folder: str  # of the logs and the resolved case
    log_format: str = "parquet"
    draw: bool = True

    @property
    def name(self) -> str:
        """The maneuver and the seed, as a name that a file can have."""
        return f"{self.case.maneuver}-seed{self.case.truth_seed}"


def names(kind: str, text: str, known: Sequence[str]) -> tuple[str, ...]:
    """Return the names of a comma list, each once. `all` means all of `known`. Raises BadInputError for none."""
    chosen = tuple(part.strip() for part in text.split(",") if part.strip())
    if not chosen:
        raise BadInputError(f"no {kind} is named: give one, several with commas, or all ({', '.join(known)})")
    return tuple(known) if chosen == ("all",) else tuple(dict.fromkeys(chosen))


def plan_tasks(
    base: Case,
    maneuvers: str,
    systems: str,
    models: str,
    seeds: int,
    options: CalibrationOptions,
    folder: str,
    log_format: str = "parquet",
    report: bool = True,
) -> list[Task]:
    """Return the tasks of a campaign: one for each maneuver and seed, with all data systems and models.

    With `report`, the flights of the first seed are drawn.

    Raises UnknownNameError or BadInputError for a name that does not exist. Nothing is flown here.
    """
    find_aircraft(base.aircraft)
    flown = maneuvers_named(maneuvers)
    # `20/1` and `20.0/1` are one system. One spelling gives it one name for its logs and one row of the results.
    sensed = tuple(dict.fromkeys(data_system(name).label for name in names("data system", systems, list(SYSTEMS))))
    fitted = names("model", models, PAPER_MODELS)
    for name in fitted:
        require_model(name)
    return [
        Task(
            replace(base, maneuver=name, truth_seed=seed, sensor_seed=seed),
            sensed,
            fitted,
            options,
            folder,
            log_format,
            draw=report and seed == 1,
        )
        for name in flown
        for seed in range(1, seeds + 1)
    ]
