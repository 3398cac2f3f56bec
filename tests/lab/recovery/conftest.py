"""The flights of the reconciliation's tests, whose longer part stands here."""

from tests.reconciliation.conftest import flight, sensed

__all__ = ["flight", "sensed"]
