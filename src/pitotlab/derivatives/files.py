"""Where the derivatives of four airplanes stand in their files, and how a file is edited. NumPy and
XML alone.
"""

import shutil
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Place:
    """A function of the file whose table, or whose only <value>, is changed.

    A number v becomes v + share (scale v + shift).
    """

    function: str
    scale: float = 1.0
    shift: float = 0.0


@dataclass(frozen=True, slots=True)
class Change:
    """A derivative changed by a share.

    `pivot` says what stays: nothing (`whole`), the value at no angle of attack (`zero`), or that at
    the angle of level flight (`trim`).
    """

    derivative: str
    share: float
    pivot: str = "whole"


Places = Mapping[str, tuple[Place, ...]]  # by pivot


# Written after reading the files. Angles of level flight are the medians of the unchanged airplanes
# on the card.
_NAMES = ("navajo", "c310", "DHC6", "c172x")
_PREFIXES = ("aero/", *["aero/coefficient/"] * 3)
_WHOLE = {  # the function of each airplane; empty where its table holds another derivative as well
    "CL_0": ("", "CLo", "", ""),
    "Cm_alpha": ("moment/pitch-alpha", "Cmalpha", "", "Cmalpha"),
    "Cm_q": ("moment/pitch-rate", "Cmq", "Cmq", "Cmq"),
    "Cm_de": ("moment/pitch-elevator", "CmDe", "CmDe", "Cmde"),
    "CY_beta": ("force/side-sideslip", "CYbeta", "CYb", "CYb"),
    "Cl_beta": ("moment/roll-sideslip", "Clbeta", "Clb", "Clb"),
    "Cl_p": ("moment/roll-damping", "Clp", "Clp", "Clp"),
    "Cl_da": ("moment/roll-aileron", "ClDa", "Clda", "Clda"),
    "Cn_beta": ("moment/yaw-sideslip", "Cnbeta", "Cnb", "Cnb"),
    "Cn_r": ("moment/yaw-damping", "Cnr", "Cnr", "Cnr"),
    "Cn_dr": ("moment/yaw-rudder", "CnDr", "Cndr", "Cndr"),
    "CD_0": ("force/drag-parasite", "CDo", "CD0", "CDo"),
    # Two of them are tables of the angle of attack.
    "CD_i": ("force/drag-induced", "CDalpha", "CDi", "CDwbh"),
}


def _slope(prefix: str, table: str, zero: float, trim: float | None, *others: str) -> Places:
    """A slope about each pivot; `zero` and `trim` are the sums of all its functions there."""
    pivots = {"zero": zero} | ({} if trim is None else {"trim": trim})
    rest = [Place(prefix + other) for other in others]
    return {pivot: (Place(prefix + table, shift=-value), *rest) for pivot, value in pivots.items()}


def _shift(function: str, value: float) -> Places:
    return {"whole": (Place(function, 0.0, value),)}


_OWN: Mapping[str, Mapping[str, Places]] = {
    "navajo": {  # the lift of the wing is a helper, which induced drag and two rate terms read as well; 1.07 deg
        "CL_alpha": _slope("aero/", "lift-clean", 0.25, 0.3434),
        "CL_0": _shift("aero/lift-clean", 0.25),
    },
    "c310": {"CL_alpha": _slope("aero/coefficient/", "CLalpha", 0.0, 0.0927)},  # 1.16 deg
    "DHC6": {  # level flight is at 0.02 deg, so the two pivots are one
        "CL_alpha": _slope("aero/coefficient/", "CLalpha", 0.44, None),
        "CL_0": _shift("aero/coefficient/CLalpha", 0.44),
        "Cm_alpha": _slope("aero/coefficient/", "Cma", 0.093, None),
    },
    "c172x": {  # two functions add up to the slope, 5.3 and 4.6 a radian; 1.35 deg
        "CL_alpha": _slope("aero/coefficient/", "CLwbh", 0.25, 0.4846, "CLalpha"),
        "CL_0": _shift("aero/coefficient/CLwbh", 0.25),
    },
}
AIRPLANES: Mapping[str, Mapping[str, Places]] = {
    name: {
        **_OWN[name],
        **{key: {"whole": (Place(prefix + each[i]),)} for key, each in _WHOLE.items() if each[i]},
    }
    for i, (name, prefix) in enumerate(zip(_NAMES, _PREFIXES, strict=True))
}


def write_edited(
    base: Path, folder: Path, places: Mapping[str, Places], changes: Sequence[Change]
) -> None:
    """Copy the folder of an airplane to a new one, named after it, with some derivatives changed in
    its file.

    Raises ValueError where the file has not one function of a name, or the function not one number
    or table.
    """
    shutil.copytree(base, folder)
    file = folder / f"{base.name}.xml"
    tree = ET.parse(file)
    for change in changes:
        for place in places[change.derivative][change.pivot]:
            _edit(tree.getroot(), place, change.share)
    file.unlink()
    tree.write(folder / f"{folder.name}.xml", encoding="utf-8", xml_declaration=True)


def _edit(root: ET.Element, place: Place, share: float) -> None:
    def changed(text: str) -> str:
        value = float(text)
        return f"{value + share * (place.scale * value + place.shift):.10g}"

    found = [each for each in root.iter("function") if each.get("name") == place.function]
    if len(found) != 1:
        raise ValueError(f"{len(found)} functions are named {place.function}")
    tables, values = list(found[0].iter("table")), list(found[0].iter("value"))
    if (len(tables) or len(values)) != 1:
        raise ValueError(f"{place.function} has {len(tables)} tables and {len(values)} values")
    for table in tables:
        headed = len(table.findall("independentVar")) > 1
        for data in table.findall("tableData"):
            data.text = _table(data.text or "", headed, changed)
    if not tables:
        values[0].text = changed(values[0].text or "")


def _table(text: str, headed: bool, changed: Callable[[str], str]) -> str:
    """The text of a table with its numbers changed, but not its first column or headings."""
    lines = [line.split() for line in text.splitlines() if line.strip()]
    for row in lines[int(headed) :]:
        row[1:] = map(changed, row[1:])
    return "".join(" ".join(line) + "\n" for line in lines)
