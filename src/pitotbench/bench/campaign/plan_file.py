"""Read the plan of a campaign from a TOML file."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pitotbench.bench.campaign.draws import Draws
from pitotbench.bench.campaign.plan import CampaignPlan, seeds_of, systems_named
from pitotbench.bench.campaign.tasks import Calibrations
from pitotbench.calibrate.options import options_from
from pitotbench.catalog import explain
from pitotbench.records.errors import BadInputError
from pitotbench.simulate.maneuvers import maneuvers_named

_TABLES = ("case", "grid", "list", "draw", "calibrate", "das", "seeds")
_LABEL = "label"


def read_plan(path: Path) -> CampaignPlan:
    """Read a plan. `case` is a case as in a case file, or the path of one, relative to the plan.

    `grid`, `list` and `draw` change its fields, `das` is a list of data systems, `seeds` a number or a range and
    `calibrate` a table of options, or several with a `label` each. Raises BadInputError or UnknownNameError for
    anything that is wrong; the message begins with the name of the file.
    """
    try:
        stated = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise BadInputError(f"{path}: cannot be read as a plan: {error}") from error
    except (ValueError, RecursionError) as error:
        raise BadInputError(f"{path}: not valid TOML: {error}") from error
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
    grid = {name: _values(name, value) for name, value in _table(stated, "grid").items()}
    rows = stated.get("list", [{}])
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows) or not rows:
        raise BadInputError("list: give one [[list]] table or several")
    systems = stated.get("das")
    plan = CampaignPlan(
        base=_base(stated.get("case", {}), folder),
        rows=[_flat(row) for row in rows],
        grid=grid,
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
        place = folder / stated
        try:
            return tomllib.loads(place.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise BadInputError(f"case {place}: cannot be read as a case file: {error}") from error
    if not isinstance(stated, dict):
        raise BadInputError("case: give a table, or the path of a case file")
    return stated


def _values(name: str, value: Any) -> Sequence[Any]:
    if name == "maneuver":
        return maneuvers_named(",".join(map(str, _list(value))))
    if isinstance(value, dict):
        raise BadInputError(f'grid: write a path in quotes, such as "wind.speed_kt" = [0, 15], not [grid.{name}]')
    if not isinstance(value, list) or not value:
        raise BadInputError(f"grid: {name} needs a list of values")
    return value


def _draws(stated: Mapping[str, Any]) -> Draws | None:
    if not stated:
        return None
    settings = {name: stated[name] for name in ("count", "method", "seed") if name in stated}
    if not isinstance(settings.get("count"), int):
        raise BadInputError("draw: state the count, such as count = 200")
    return Draws({name: spread for name, spread in stated.items() if name not in settings}, **settings)


def _calibrations(stated: Any) -> Calibrations:
    """Return every model of every table of options, with the table's label."""
    tables = stated if isinstance(stated, list) else [stated]
    found = []
    for table in tables:
        choices = {name: value for name, value in table.items() if name not in (_LABEL, "model")}
        options = options_from(choices)
        for model in _list(table.get("model", "inverse+")):
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
