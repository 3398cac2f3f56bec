"""Where the derivatives of four airplanes stand in their files, and how a file is edited. NumPy and XML alone."""

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
    """A derivative changed by a share. `pivot` says what stays: nothing (`whole`), or the value at an angle of attack.

    `zero` keeps the value at no angle of attack, `trim` that at the angle of level flight.
    """

    derivative: str
    share: float
    pivot: str = "whole"


Places = Mapping[str, tuple[Place, ...]]  # by pivot


def _whole(prefix: str, functions: Mapping[str, str]) -> dict[str, Places]:
    return {name: {"whole": (Place(prefix + function),)} for name, function in functions.items()}


_COEFFICIENT = "aero/coefficient/"
# Written after reading the files. The angles of level flight are the medians of the unchanged airplanes on the card.
AIRPLANES: Mapping[str, Mapping[str, Places]] = {
    "navajo": {
        # The lift of the wing is a helper's table, which induced drag and two rate terms read as well. 1.07 deg.
        "CL_alpha": {
            "zero": (Place("aero/lift-clean", shift=-0.25),),
            "trim": (Place("aero/lift-clean", shift=-0.3434),),
        },
        "CL_0": {"whole": (Place("aero/lift-clean", 0.0, 0.25),)},
        **_whole(
            "aero/",
            {
                "Cm_alpha": "moment/pitch-alpha",
                "Cm_q": "moment/pitch-rate",
                "Cm_de": "moment/pitch-elevator",
                "CY_beta": "force/side-sideslip",
                "Cl_beta": "moment/roll-sideslip",
                "Cl_p": "moment/roll-damping",
                "Cl_da": "moment/roll-aileron",
                "Cn_beta": "moment/yaw-sideslip",
                "Cn_r": "moment/yaw-damping",
                "Cn_dr": "moment/yaw-rudder",
                "CD_0": "force/drag-parasite",
                "CD_i": "force/drag-induced",
            },
        ),
    },
    "c310": {
        "CL_alpha": {  # its table is 0 at no angle of attack; 1.16 deg
            "zero": (Place("aero/coefficient/CLalpha"),),
            "trim": (Place("aero/coefficient/CLalpha", shift=-0.0927),),
        },
        **_whole(
            _COEFFICIENT,
            {
                "CL_0": "CLo",
                "Cm_alpha": "Cmalpha",
                "Cm_q": "Cmq",
                "Cm_de": "CmDe",
                "CY_beta": "CYbeta",
                "Cl_beta": "Clbeta",
                "Cl_p": "Clp",
                "Cl_da": "ClDa",
                "Cn_beta": "Cnbeta",
                "Cn_r": "Cnr",
                "Cn_dr": "CnDr",
                "CD_0": "CDo",
                "CD_i": "CDalpha",  # a table of the angle of attack
            },
        ),
    },
    "DHC6": {
        # Level flight is at 0.02 deg: the two pivots are one.
        "CL_alpha": {"zero": (Place("aero/coefficient/CLalpha", shift=-0.44),)},
        "CL_0": {"whole": (Place("aero/coefficient/CLalpha", 0.0, 0.44),)},
        "Cm_alpha": {"zero": (Place("aero/coefficient/Cma", shift=-0.093),)},
        **_whole(
            _COEFFICIENT,
            {
                "Cm_q": "Cmq",
                "Cm_de": "CmDe",
                "CY_beta": "CYb",
                "Cl_beta": "Clb",
                "Cl_p": "Clp",
                "Cl_da": "Clda",
                "Cn_beta": "Cnb",
                "Cn_r": "Cnr",
                "Cn_dr": "Cndr",
                "CD_0": "CD0",
                "CD_i": "CDi",
            },
        ),
    },
    "c172x": {
        # Two functions add up to the slope, 5.3 and 4.6 a radian; the first one takes both pivots. 1.35 deg.
        "CL_alpha": {
            "zero": (Place("aero/coefficient/CLwbh", shift=-0.25), Place("aero/coefficient/CLalpha")),
            "trim": (Place("aero/coefficient/CLwbh", shift=-0.4846), Place("aero/coefficient/CLalpha")),
        },
        "CL_0": {"whole": (Place("aero/coefficient/CLwbh", 0.0, 0.25),)},
        **_whole(
            _COEFFICIENT,
            {
                "Cm_alpha": "Cmalpha",
                "Cm_q": "Cmq",
                "Cm_de": "Cmde",
                "CY_beta": "CYb",
                "Cl_beta": "Clb",
                "Cl_p": "Clp",
                "Cl_da": "Clda",
                "Cn_beta": "Cnb",
                "Cn_r": "Cnr",
                "Cn_dr": "Cndr",
                "CD_0": "CDo",
                "CD_i": "CDwbh",  # a table of the angle of attack
            },
        ),
    },
}


def write_edited(base: Path, folder: Path, places: Mapping[str, Places], changes: Sequence[Change]) -> None:
    """Copy the folder of an airplane to a new one, named after it, with some derivatives changed in its file.

    Raises ValueError where the file has not one function of a name, or the function not one number or table.
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
    """The text of a table with its numbers changed, but neither its first column nor its line of columns."""
    lines = [line.split() for line in text.splitlines() if line.strip()]
    kept, rows = lines[: int(headed)], lines[int(headed) :]
    return "\n".join(" ".join(line) for line in [*kept, *([row[0], *map(changed, row[1:])] for row in rows)]) + "\n"
