"""The numbers that decide a verdict stand in one record."""

import pytest

from pitotbench.reconciliation.thresholds import THRESHOLDS


def test_a_threshold_cannot_be_changed() -> None:
    with pytest.raises(AttributeError):
        THRESHOLDS.named_from = 1.0  # type: ignore[misc]
