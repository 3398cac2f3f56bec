"""Engines that are held cost no time, and what a force of the air changes is the same with them."""

import numpy as np
import pytest

from pitotbench.bench.null_flights import aircraft_model
from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import AircraftEffect
from pitotbench.effects.overlay import Overlay
from pitotbench.reconciliation.track import answer, motion_of, track_of


@pytest.mark.parametrize(("name", "column"), [("belly_pod", 0), ("flap_not_up", 2)])
def test_held_engines_fall_out_of_the_difference(sensed, name: str, column: int) -> None:
    log = sensed(das="50/50")
    track = track_of(log.select(log.time < log.time[0] + 25.0))
    motion = motion_of(track, np.arange(0, len(track.time), 50))
    model, effect = aircraft_model("navajo"), EFFECTS[name]
    assert model is not None
    assert isinstance(effect, AircraftEffect)
    overlay = effect.overlay(effect.typical(), model.baseline)
    changes = [
        answer(lambda m, run=run: model.react(m, overlay, run), motion)
        - answer(lambda m, run=run: model.react(m, Overlay(), run), motion)
        for run in (True, False)
    ]
    running, held = (change[:, column] for change in changes)
    assert np.abs(running).max() > 0.01
    assert np.allclose(held, running, rtol=0.02, atol=0.01 * np.abs(running).max())
