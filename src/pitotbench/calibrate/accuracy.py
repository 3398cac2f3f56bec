"""Stated accuracies of what the residual cannot show: they widen the bound, each by its share."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import isfinite

from pitotbench.catalog import explain
from pitotbench.records.errors import BadInputError

WITHOUT_TEMPERATURE = 10.0  # K, 2σ: how far a day may be from the standard one where the log holds no temperature


@dataclass(frozen=True, slots=True)
class Accuracies:
    """2σ of constant errors, the same over a log (and over several logs of one airplane); 0 leaves one out.

    temperature_k [K] of the probe; recovery_factor [-]; static_pressure_pa [Pa] of the transducer;
    impact_pressure_zero_pa [Pa], the zero offset of the impact pressure (wide: it is found from the log);
    velocity_mps [m/s] of each horizontal GPS component; latency_s [s] by which GPS velocity trails the air data.
    Raises BadInputError for a negative or infinite one.
    """

    temperature_k: float = 0.0
    recovery_factor: float = 0.0
    static_pressure_pa: float = 0.0
    impact_pressure_zero_pa: float = 0.0
    velocity_mps: float = 0.0
    latency_s: float = 0.0

    def __post_init__(self) -> None:
        for f in fields(self):
            value = getattr(self, f.name)
            if not isfinite(value) or value < 0.0:
                raise BadInputError(f"accuracy {f.name} = {value:g}: state a 2σ accuracy of zero or more")


def parse_accuracies(text: str) -> Accuracies:
    """Accuracies from `temperature_k=1,static_pressure_pa=40`. Raises BadInputError that names the known ones."""
    stated = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, equals, number = part.partition("=")
        try:
            stated[name.strip()] = float(number)
        except ValueError as error:
            raise BadInputError(f"accuracy {part!r}: write name=2σ, such as temperature_k=1") from error
        if not equals:
            raise BadInputError(f"accuracy {part!r}: write name=2σ, such as temperature_k=1")
    return accuracies_from(stated)


def accuracies_from(stated: Mapping[str, float]) -> Accuracies:
    """Accuracies by name, units in the names. Raises BadInputError that names the known ones."""
    if not isinstance(stated, Mapping):  # from the header of a log, which can hold anything
        raise BadInputError(f"accuracy {stated!r}: state a table of 2σ by name, such as temperature_k = 1")
    known = [f.name for f in fields(Accuracies)]
    for name, value in stated.items():
        if name not in known:
            raise BadInputError(explain("accuracy", name, known))
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise BadInputError(f"accuracy {name}: {value!r} is not a number")
    return Accuracies(**{name: float(value) for name, value in stated.items()})
