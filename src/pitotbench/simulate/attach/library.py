"""Find the aircraft and the parts that JSBSim's own package ships."""

from functools import cache
from importlib.util import find_spec
from pathlib import Path

ENGINES, SYSTEMS = "engine", "systems"  # folders of parts that the aircraft share


@cache
def library() -> Path:
    """Return the folder of JSBSim's package, which holds `aircraft`, `engine` and `systems`."""
    spec = find_spec("jsbsim")  # located, not imported: that takes longer than the search
    places = list(spec.submodule_search_locations or ()) if spec else []
    return Path(places[0]) if places else Path()


@cache
def library_aircraft() -> dict[str, Path]:
    """Return JSBSim's own aircraft by name; each is the JSBSim file in its folder."""
    files = sorted((library() / "aircraft").glob("*/*.xml"))
    return {file.stem: file for file in files if file.stem == file.parent.name}
