"""Read the airspeed calibration of a handbook: KCAS by KIAS and configuration."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pitotbench.records import BadInputError
from pitotbench.records.calibration import PublishedCurve
from pitotbench.units import to_si

if TYPE_CHECKING:
    import pandas as pd

_UNITS = {"mph": "mph", "km/h": "kmh", "kmh": "kmh", "kt": "kt", "kts": "kt", "knots": "kt"}
# "KIAS", "IAS [mph]", "indicated_airspeed_kt"; what follows a calibrated one is a configuration:
# "KCAS flaps 30".
_AIRSPEED = re.compile(
    r"(?P<knots>k)?(?P<kind>ias|cas|indicated[ _]airspeed|calibrated[ _]airspeed)"
    r"[ _]*[\[(]?(?P<unit>mph|km/h|kmh|kts?|knots)?[\])]?(?:[ _,:]+(?P<rest>.+))?",
    re.IGNORECASE,
)
_SEPARATORS = ";\t"  # in place of commas
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
    table = _table(path)
    named = {str(name): _AIRSPEED.fullmatch(str(name).strip()) for name in table.columns}
    airspeeds = {name: found for name, found in named.items() if found}
    indicated = [n for n, found in airspeeds.items() if found["kind"][0].lower() == "i"]
    calibrated = [n for n in airspeeds if n not in indicated]
    if len(indicated) != 1 or not calibrated:
        raise BadInputError(f"{path}: {_other_table(table)}")
    across = _airspeeds(path, table, indicated[0], airspeeds[indicated[0]])
    by = next((n for n in table.columns if str(n).strip().lower() in _CONFIGURATIONS), None)
    curves = []
    for name in calibrated:
        found = airspeeds[name]
        values = _airspeeds(path, table, name, found)
        for configuration, rows in _parts(table, by):
            words = " ".join(
                each for each in (configuration, (found and found["rest"]) or "") if each
            )
            known = rows & np.isfinite(across) & np.isfinite(values)
            curves.append(_curve(path, words, across[known], values[known]))
    return tuple(curves)


def is_published(path: Path) -> bool:
    """Return whether a file is such a table."""
    try:
        return bool(read_published(path))
    except BadInputError:
        return False


def _table(path: Path) -> "pd.DataFrame":
    import pandas as pd

    if not path.is_file():
        raise BadInputError(f"{path}: no such file; the table of a handbook is a CSV file")
    try:
        with path.open(encoding="utf-8-sig") as opened:
            head = opened.readline()
        between = next((each for each in _SEPARATORS if each in head), ",")
        return pd.read_csv(
            path, sep=between, comment="#", encoding="utf-8-sig", skipinitialspace=True
        )
    except (ValueError, pd.errors.ParserError) as error:
        raise BadInputError(f"{path}: no table with a row of headings ({error}); {_WAY}") from error


def _other_table(table: "pd.DataFrame") -> str:
    names = [str(name).strip() for name in table.columns]
    if "figure" in names:
        return (
            "this is a handbook's table of performance; give it to `pitotbench aircraft "
            "performance AIRCRAFT --handbook`, and here one of airspeeds: " + _WAY
        )
    return f"no handbook's table of airspeeds (its columns: {', '.join(names[:8])}); {_WAY}"


def _airspeeds(
    path: Path, table: "pd.DataFrame", name: str, found: "re.Match[str] | None"
) -> np.ndarray:
    assert found is not None
    unit = (found["unit"] or ("kt" if found["knots"] else "")).lower()
    if not unit:
        raise BadInputError(
            f"{path}: {name!r} does not say its unit; write K{name} or {name} [mph]"
        )
    column = table[name]
    values = (
        column.to_numpy(dtype=np.float64, na_value=np.nan) if column.dtype.kind in "if" else None
    )
    if values is None:
        raise BadInputError(
            f"{path}: {name} holds text in place of a number; leave such a cell blank"
        )
    return np.asarray(to_si(values, _UNITS[unit]))


def _parts(table: "pd.DataFrame", by: object) -> Iterator[tuple[str, np.ndarray]]:
    if by is None:
        yield "", np.ones(len(table), dtype=np.bool_)
        return
    labels = table[by].astype(str).str.strip()
    for label in dict.fromkeys(labels):
        yield label, (labels == label).to_numpy()


def _curve(
    path: Path, configuration: str, indicated: np.ndarray, calibrated: np.ndarray
) -> PublishedCurve:
    where = f"{path}{f', {configuration}' if configuration else ''}"
    order = np.argsort(indicated, kind="stable")
    indicated, calibrated = indicated[order], calibrated[order]
    if len(indicated) < _FEWEST:
        raise BadInputError(f"{where}: {len(indicated)} rows with both airspeeds; {_WAY}")
    if indicated[0] <= 0.0 or np.any(np.abs(calibrated - indicated) > _MOST_OFF * indicated):
        raise BadInputError(
            f"{where}: an airspeed differs from its other by more than half; check the units and "
            "the order of the columns"
        )
    if np.any(np.diff(indicated) <= 0.0) or np.any(np.diff(calibrated) <= 0.0):
        raise BadInputError(
            f"{where}: an airspeed is given twice, or KCAS does not grow with KIAS; correct the "
            "rows, or name their configuration"
        )
    return PublishedCurve(path.name, configuration, indicated, calibrated)
