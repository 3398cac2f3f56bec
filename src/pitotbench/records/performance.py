"""The performance of a model in steady flight, compared with a handbook."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PerformanceFigure:
    """One figure of a model's performance [`unit`] in a condition.

    The published one stands beside it where there is any. `altitude` [m] of a climb.
    """

    name: str
    condition: str
    model: float
    unit: str
    published: float | None = None
    altitude: float | None = None

    @property
    def difference(self) -> float | None:
        """The model's figure less the published one [`unit`]."""
        return None if self.published is None else self.model - self.published


@dataclass(frozen=True, slots=True)
class Performance:
    """The performance of an aircraft at a mass [kg].

    `skipped` holds what it lacks: name and reason.
    """

    aircraft: str
    mass: float
    figures: tuple[PerformanceFigure, ...]
    skipped: tuple[tuple[str, str], ...]
