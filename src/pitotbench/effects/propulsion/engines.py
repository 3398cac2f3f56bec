"""Find the left and the right engine of a twin, and check that an aircraft has the properties of an effect."""

from pitotbench.effects.overlay import Baseline
from pitotbench.records.errors import BadInputError


def left_and_right(effect: str, baseline: Baseline) -> tuple[int, int]:
    """Return JSBSim's numbers of the left and the right engine. Raises BadInputError unless there are two."""
    if len(baseline.engines) != 2:
        raise BadInputError(f"effect {effect!r} needs a twin; {baseline.aircraft!r} has {len(baseline.engines)}")
    # The second coordinate of a structural location is positive to the right.
    left, right = sorted(range(2), key=lambda i: baseline.engines[i].location[1])
    return left, right


def require_declared(effect: str, baseline: Baseline, *paths: str) -> None:
    """Raise BadInputError where an aircraft lacks properties that an effect sets."""
    missing = [path for path in paths if path not in baseline.declared]
    if missing:
        raise BadInputError(
            f"effect {effect!r} sets {', '.join(missing)}, which {baseline.aircraft!r} does not have; leave it out"
        )
