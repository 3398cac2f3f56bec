"""Write aircraft variants: copies of a folder with an overlay of effects in the JSBSim file."""

import re
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path
from tempfile import TemporaryDirectory

from pitotbench.effects.effect import RECORDING_START
from pitotbench.effects.overlay import (
    Expression,
    FunctionScaling,
    Overlay,
    Point,
    difference,
    operation,
    product,
    quotient,
    total,
)
from pitotbench.effects.propulsion import BIASES
from pitotbench.records import BadInputError
from pitotbench.simulation.aircraft_files import parse_xml

ORIGIN = "variant.toml"  # in the folder of a variant: its effects, and where they come from
ROOT = "effects"  # of the property tree: sizes, functions and outputs of an overlay
DYNAMICS = ("lag", "rate_limit", "hysteresis_width", "deadband_width")  # of an actuator
NOT_YET = 1e9  # s, its value until recording begins


def write_variant(
    original: Path,
    shelf: Path,
    name: str,
    overlay: Overlay,
    at_once: bool = False,
    origin: str = "",
    anew: bool = False,
    air_rates: bool = False,
) -> Path:
    """Write a variant of an aircraft into a new folder `<shelf>/<name>` and return the folder.

    With `at_once` the actuators in its file follow their commands without a lag, and no effect
    moves a throttle, so that a control can be put where a log has it. With `air_rates` its
    aerodynamics read the rates of the flow angles against the air. `origin` is the text of its
    `variant.toml`. With `anew` the file of a variant that is there is replaced, whole or not at
    all.

    The original is copied, never changed, and the file keeps its comments. The original may itself
    be a variant: the new effects are then added to its effects. Raises BadInputError where the
    folder exists.
    """
    folder = shelf / name
    if folder.exists() and not anew:
        raise BadInputError(f"{folder} is there already; choose another name for the variant")
    tree = parse_xml(original / f"{original.name}.xml", comments=True)
    if not overlay.is_empty():
        _insert(tree.getroot(), overlay)
    if air_rates:
        _read_air_rates(tree.getroot())
    for actuator in lagging_actuators(tree.getroot()) if at_once else ():
        for part in [child for child in actuator if child.tag in DYNAMICS]:
            actuator.remove(part)
    for channel, part in throttle_settings(tree.getroot()) if at_once else ():
        channel.remove(part)
    ET.indent(tree)
    shelf.mkdir(parents=True, exist_ok=True)
    # The copy is made in a hidden folder and renamed: an error leaves no incomplete variant.
    with TemporaryDirectory(dir=shelf, prefix=".") as scratch:
        copy = Path(shutil.copytree(original, Path(scratch) / name))
        (copy / f"{original.name}.xml").unlink()
        tree.write(copy / f"{name}.xml", encoding="unicode")
        if origin:
            (copy / ORIGIN).write_text(origin, encoding="utf-8")
        if folder.exists():  # the rest of the folder is that of the original, as before
            for file in (ORIGIN, f"{name}.xml"):
                (copy / file).replace(folder / file)
        else:
            copy.rename(folder)
    return folder


def lagging_actuators(root: ET.Element) -> list[ET.Element]:
    """Return the actuators of an aircraft's file that do not follow their commands at once."""
    return [each for each in root.iter("actuator") if any(child.tag in DYNAMICS for child in each)]


def throttle_settings(root: ET.Element) -> list[tuple[ET.Element, ET.Element]]:
    """Return the components by which effects move a throttle, each after its channel."""
    channels = root.iterfind("system/channel")
    return [(c, part) for c in channels for part in c if part.findtext("output") in BIASES]


def ground_rates(root: ET.Element) -> list[ET.Element]:
    """Return where the aerodynamics of an aircraft's file read JSBSim's rate of a flow angle."""
    every = root.iterfind("aerodynamics//*")
    return [element for element in every if (element.text or "").strip() in AIR_RATES]


def _read_air_rates(root: ET.Element) -> None:
    """Let the aerodynamics read the rates of the flow angles against the air.

    JSBSim differentiates the velocity over the ground, as if the wind turned with the airplane. At
    150 kt in a wind of 20 kt, a roll of 10 deg/s changes the rate of the angle of attack by up to
    1.3 deg/s, and the moment of the downwash lag with it. In body axes a steady wind w changes by
    -ω × w, so that ω × w is missing in the acceleration through the air.
    """
    places = [(place, (place.text or "").strip()) for place in ground_rates(root)]
    for place, path in places:
        place.text = AIR_RATES[path][0]
    # Functions outside the axes are computed before these.
    for path in sorted({path for _, path in places}):
        _part(root, "aerodynamics").insert(0, _function(*AIR_RATES[path], ROOT))


def _air_rates() -> dict[str, tuple[str, Expression]]:
    """JSBSim's rates of the flow angles, each with the property that replaces it, and its value."""
    p, q, r = (f"velocities/{rate}-rad_sec" for rate in "pqr")
    u, v, w = (f"velocities/{axis}-aero-fps" for axis in "uvw")
    x, y, z = (
        difference(f"velocities/{axis}-fps", f"velocities/{axis}-aero-fps") for axis in "uvw"
    )
    du = difference(product(q, z), product(r, y))
    dv = difference(product(r, x), product(p, z))
    dw = difference(product(p, y), product(q, x))
    level = operation("max", total(product(u, u), product(w, w)), 1.0)  # at rest there is no angle
    speed = total(level, product(v, v))
    alpha = quotient(difference(product(u, dw), product(w, du)), level)
    along = product(v, total(product(u, du), product(v, dv), product(w, dw)))
    beta = quotient(difference(product(dv, speed), along), product(speed, operation("sqrt", level)))
    ground = {"alphadot-rad_sec": alpha, "betadot-rad_sec": beta}
    return {
        f"aero/{rate}": (f"air/{rate}", total(f"aero/{rate}", off)) for rate, off in ground.items()
    }


AIR_RATES = _air_rates()


def overlay_text(original: Path, overlay: Overlay) -> str:
    """Return the elements that a variant adds to the file of an aircraft, as XML text.

    Each element stands inside the part of the file to which it is added.
    """
    # Elements are compared by identity: those that were there before the insertion are the
    # original's.
    root = parse_xml(original / f"{original.name}.xml", comments=True).getroot()
    before = {id(element) for element in root.iter()}
    _insert(root, overlay)
    _prune(root, before)
    root.insert(
        0, ET.Comment(f" added to the file of {original.name}; the rest of it is untouched ")
    )
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _prune(element: ET.Element, old: set[int]) -> None:
    """Remove all elements that are old and hold nothing new."""
    for child in list(element):
        _prune(child, old)
        if id(child) in old and (
            len(child) == 0 or not any(id(e) not in old for e in child.iter())
        ):
            element.remove(child)


def free_branch(root: ET.Element) -> str:
    """Return the branch of properties that the next overlay of an aircraft's file gets.

    `effects`, where the file holds an overlay already `effects-2`, then `effects-3`.
    """
    taken = {element.get("name") for element in root.iter("system")}
    return next(
        name for n in range(1, 100) if (name := f"{ROOT}-{n}" if n > 1 else ROOT) not in taken
    )


def _insert(root: ET.Element, overlay: Overlay) -> None:
    """Put each part of an overlay where JSBSim looks for it, under a free branch of properties."""
    branch = free_branch(root)
    _insert_system(root, overlay, branch)
    for number, function in enumerate(overlay.functions):
        axis = _part(_part(root, "aerodynamics"), f"axis[@name='{function.axis}']")
        axis.append(_function(f"{branch}/{function.axis.lower()}-{number}", function.value, branch))
    for scaling in overlay.scalings:
        _scale(root, scaling, branch)
    for mass in overlay.masses:
        point = ET.SubElement(
            _part(root, "mass_balance"), "pointmass", name=f"{branch} {_next_mass(root)}"
        )
        ET.SubElement(point, "weight", unit="LBS").text = "0"
        point.append(_location(mass.location))
    if overlay.forces:
        _insert_forces(root, overlay, branch)


def _scale(root: ET.Element, scaling: FunctionScaling, branch: str) -> None:
    """Put the body of a function of the aerodynamics into a product, and the product into a sum."""
    place = _part(_part(root, "aerodynamics"), f".//function[@name='{scaling.function}']")
    body = [child for child in place if isinstance(child.tag, str) and child.tag != "description"]
    for child in body:
        place.remove(child)
    total = ET.SubElement(place, "sum")
    scaled = ET.SubElement(total, "product")
    scaled.append(ET.fromstring(on_branch(branch, scaling.factor)))
    scaled.extend(body)
    total.append(ET.fromstring(on_branch(branch, scaling.added)))


def _next_mass(root: ET.Element) -> int:
    """Return the number that JSBSim gives to the next point mass."""
    return len(root.findall("mass_balance/pointmass"))


def _insert_system(root: ET.Element, overlay: Overlay, branch: str) -> None:
    """Insert the system that declares the sizes and writes the properties, each by a component.

    Components write at each step.
    """
    system = ET.Element("system", name=branch)
    timed = overlay.winds or RECORDING_START in repr(overlay)
    declared = (*overlay.sizes, *(((RECORDING_START, NOT_YET),) if timed else ()))
    for path, value in declared:
        ET.SubElement(system, "property", value=repr(value)).text = on_branch(branch, path)
    channel = ET.SubElement(system, "channel", name=branch)
    channel.extend(ET.fromstring(on_branch(branch, text)) for text in overlay.filters)
    masses = _next_mass(root)
    outputs = [(s.path, s.value) for s in overlay.settings]
    outputs += [
        (f"inertia/pointmass-weight-lbs[{masses + i}]", mass.weight)
        for i, mass in enumerate(overlay.masses)
    ]
    outputs += _gusts(overlay)
    for number, (path, value) in enumerate(outputs):
        component = ET.SubElement(channel, "fcs_function", name=f"{branch}/output-{number}")
        function = _function(None, value, branch)
        if number < len(overlay.settings):
            _add_earlier(root, function)
        component.append(function)
        ET.SubElement(component, "output").text = path
    # Systems run in the order of the file. This one runs after the aircraft's, so that its settings
    # are the last.
    before = (i for i, element in enumerate(root) if element.tag in ("system", "propulsion"))
    position = max(before, default=-1) + 1  # a glider may have neither
    root.insert(position, system)


def _add_earlier(root: ET.Element, function: ET.Element) -> None:
    """Let a setting read each size plus those of the same effect in earlier overlays of the file.

    Of two settings of one property the last one alone counts.
    """
    declared = [element.text or "" for element in root.iterfind("system/property")]
    for element in [*function.iter("property")]:
        own = element.text or ""
        earlier = [
            path
            for path in declared
            if path.startswith(ROOT) and path.partition("/")[2] == own.partition("/")[2]
        ]
        if earlier:
            element.tag, element.text = "sum", None
            for path in (own, *earlier):
                ET.SubElement(element, "property").text = path


def _gusts(overlay: Overlay) -> list[tuple[str, Expression]]:
    """Return the sum of the wind terms by axis, on JSBSim's property beside wind and turbulence."""
    found = []
    for toward in ("north", "east", "down"):
        terms = [wind.value for wind in overlay.winds if wind.toward == toward]
        path = f"atmosphere/gust-{toward}-fps"
        if terms:
            found.append((path, "<sum>" + "".join(terms) + "</sum>"))
    return found


def _insert_forces(root: ET.Element, overlay: Overlay, branch: str) -> None:
    reactions = root.find("external_reactions")
    if reactions is None:
        reactions = ET.SubElement(root, "external_reactions")
    for number, force in enumerate(overlay.forces):
        element = ET.SubElement(reactions, "force", name=f"{branch}-{number}", frame="BODY")
        element.append(_function(None, force.value, branch))
        element.append(_location(force.location))
        direction = ET.SubElement(element, "direction")
        for axis, value in zip("xyz", ("1", "0", "0"), strict=True):
            ET.SubElement(direction, axis).text = value


def _function(name: str | None, value: Expression, branch: str) -> ET.Element:
    element = ET.Element("function", {"name": name} if name else {})
    element.append(ET.fromstring(on_branch(branch, value)))
    return element


def _location(point: Point) -> ET.Element:
    element = ET.Element("location", unit="IN")
    for axis, value in zip("xyz", point, strict=True):
        ET.SubElement(element, axis).text = repr(value)
    return element


def _part(element: ET.Element, path: str) -> ET.Element:
    found = element.find(path)
    if found is None:
        raise BadInputError(
            f"the aircraft's file has no {path}, which an effect adds to; leave the effect out"
        )
    return found


def on_branch(branch: str, text: str) -> str:
    """Return the text with the sizes of an overlay, root/effect/parameter, moved under a branch.

    A function that an earlier overlay added, root/function, stays where it is.
    """
    return re.sub(rf"{ROOT}/(?=[^/<>]+/)", f"{branch}/", text)
