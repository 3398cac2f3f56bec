"""Read the airspeed calibration of a handbook: KCAS by KIAS and configuration."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pitotbench.logbook.columns import Table, numbers, texts, within
from pitotbench.logbook.csv import read_csv
from pitotbench.records import BadInputError
from pitotbench.records.calibration import PublishedCurve
from pitotbench.records.intake import require_regular
from pitotbench.units import Array, Booleans, to_si

_UNITS = {"mph": "mph", "km/h": "kmh", "kmh": "kmh", "kt": "kt", "kts": "kt", "knots": "kt"}
# "KIAS", "IAS [mph]", "indicated_airspeed_kt"; what follows a calibrated one is a configuration:
# "KCAS flaps 30".
_AIRSPEED = re.compile(
    r"(?P<knots>k)?(?P<kind>ias|cas|indicated[ _]airspeed|calibrated[ _]airspeed)"
    r"[ _]*[\[(]?(?P<unit>mph|km/h|kmh|kts?|knots)?[\])]?(?:[ _,:]+(?P<rest>.+))?",
    re.IGNORECASE,
)
_CONFIGURATIONS = ("configuration", "flaps")
_FEWEST = 2  # rows of a curve
_MOST_OFF = 0.5  # share of the indicated airspeed: a larger correction is a mistake of the table
_WAY = "give a row an airspeed, in the columns KIAS, KCAS and, where it has several, configuration"


def read_published(path: Path) -> tuple[PublishedCurve, ...]:
    """Return the curves of a handbook's table (CSV), one a configuration.

    The columns are KIAS and KCAS, or IAS and CAS with a unit (`IAS [mph]`); `configuration` or
    `flaps` names the configuration of a row, or a column of its own does (`KCAS flaps 30`). Rows
    may stand in any order. Raises BadInputError for another table, which it names where it is
    known, and for an airspeed that is missing, negative, given twice, or far from its other.
    """
    with within(path):
        require_regular(path)
        table = read_csv(path)
        return tuple(_curves(path.name, table))


def _curves(file: str, table: Table) -> Iterator[PublishedCurve]:
    named = {name: _AIRSPEED.fullmatch(name) for name in table.names}
    airspeeds = {name: found for name, found in named.items() if found}
    indicated = [n for n, found in airspeeds.items() if found["kind"][0].lower() == "i"]
    calibrated = [n for n in airspeeds if n not in indicated]
    if len(indicated) != 1 or not calibrated:
        raise BadInputError(_other_table(table))
    across = _airspeeds(table, indicated[0], airspeeds[indicated[0]])
    by = next((n for n in table.names if n.lower() in _CONFIGURATIONS), None)
    for name in calibrated:
        values = _airspeeds(table, name, airspeeds[name])
        for configuration, rows in _parts(table, by):
            words = " ".join(filter(None, (configuration, airspeeds[name]["rest"])))
            known = rows & np.isfinite(across) & np.isfinite(values)
            yield _curve(file, words, across[known], values[known])


def is_published(path: Path) -> bool:
    """Return whether a file is such a table."""
    try:
        return bool(read_published(path))
    except BadInputError:
        return False


def _other_table(table: Table) -> str:
    if "figure" in table.names:
        return (
            "this is a handbook's table of performance; give it to `pitotbench aircraft "
            "performance AIRCRAFT --handbook`, and here one of airspeeds: " + _WAY
        )
    return f"no handbook's table of airspeeds (its columns: {', '.join(table.names[:8])}); {_WAY}"


def _airspeeds(table: Table, name: str, found: re.Match[str]) -> Array:
    unit = (found["unit"] or ("kt" if found["knots"] else "")).lower()
    if not unit:
        raise BadInputError(f"{name!r} does not say its unit; write K{name} or {name} [mph]")
    return to_si(numbers(name, table.column(name)), _UNITS[unit])


def _parts(table: Table, by: str | None) -> Iterator[tuple[str, Booleans]]:
    if by is None:
        yield "", np.ones(len(table), dtype=np.bool_)
        return
    column = table.column(by)
    labels = column.astype(str) if column.dtype.kind == "f" else texts(by, column)
    for label in dict.fromkeys(labels.tolist()):
        yield label, labels == label


def _curve(file: str, configuration: str, indicated: Array, calibrated: Array) -> PublishedCurve:
    where = f"{configuration}: " if configuration else ""
    order = np.argsort(indicated, kind="stable")
    indicated, calibrated = indicated[order], calibrated[order]
    if len(indicated) < _FEWEST:
        raise BadInputError(f"{where}{len(indicated)} rows with both airspeeds; {_WAY}")
    if indicated[0] <= 0.0 or np.any(np.abs(calibrated - indicated) > _MOST_OFF * indicated):
        raise BadInputError(
            f"{where}an airspeed differs from its other by more than half; check the units and "
            "the order of the columns"
        )
    if np.any(np.diff(indicated) <= 0.0) or np.any(np.diff(calibrated) <= 0.0):
        raise BadInputError(
            f"{where}an airspeed is given twice, or KCAS does not grow with KIAS; correct the "
            "rows, or name their configuration"
        )
    return PublishedCurve(file, configuration, indicated, calibrated)
