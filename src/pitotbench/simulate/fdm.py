"""Load the JSBSim model of an aircraft's folder."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pitotbench.records.errors import BadInputError

if TYPE_CHECKING:
    from pitotbench.simulate.transcript import Transcript


class SimulationError(BadInputError):
    """The case cannot be flown. The message says what happened, where in the flight, and what JSBSim reported."""


def load_fdm(
    aircraft: str, folder: Path, rate: float, parts: tuple[Path, Path] | None = None
) -> tuple[Any, "Transcript"]:
    """Return the JSBSim model of an aircraft, to be run at a rate [Hz], and the transcript of JSBSim's messages.

    `folder` holds `<folder name>.xml`; `aircraft` names it in messages. `parts` are the folders of engines and
    systems, by default `Engines` and `Systems` in that folder.
    Raises SimulationError where JSBSim refuses a file.
    """
    import jsbsim  # loads with the first aircraft, not with the table of maneuvers

    from pitotbench.simulate.transcript import Transcript

    # The logger comes first: JSBSim reports errors of a file while it loads, and never again.
    transcript = Transcript()
    jsbsim.set_logger(transcript)
    jsbsim.FGJSBBase().debug_lvl = 0  # type: ignore[no-untyped-call]
    fdm = jsbsim.FGFDMExec(None)
    fdm.set_debug_level(0)
    fdm.set_dt(1.0 / rate)
    engines, systems = parts or (folder / "Engines", folder / "Systems")
    try:
        loaded = fdm.load_model_with_paths(folder.name, str(folder.parent), str(engines), str(systems))
    except jsbsim.BaseError as error:  # what JSBSim throws for a file that it cannot read
        said = transcript.said() or f" JSBSim says: {' '.join(str(error).split())}"
        raise SimulationError(f"JSBSim cannot load aircraft {aircraft!r}.{said}") from error
    if not loaded:
        raise SimulationError(f"JSBSim cannot load aircraft {aircraft!r}.{transcript.said()}")
    return fdm, transcript
