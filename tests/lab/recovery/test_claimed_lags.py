"""What the signature of a lag claims is what the lag does to the log of a flight, seen by its sensors
alone.
"""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench import Case, Flight, fly
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.equations import noise_of_log
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout, lay_out
from pitotbench.reconciliation.signatures import residual_change
from pitotbench.records.case import EffectSpec
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system
from pitotbench.units import Array

NO_EFFECTS = Catalog("effect", {})

LAGS = ("pitot_lag", "air_data_latency")
SIZE = 0.3  # s


def laid_out(flight: Flight, das: str, lag: str = "") -> Layout:
    """The layout of a flight with one noise, and with a lag or without one."""
    effects = (EffectSpec(lag, {EFFECTS[lag].parameters[0].name: SIZE}),) if lag else ()
    late = replace(flight, case=replace(flight.case, effects=effects))
    log = record(late, data_system(das), 4712)
    return lay_out(log, None, AnalysisSetting(), NO_EFFECTS)


def claimed_and_done(flight: Flight, without: Layout, das: str, lag: str) -> tuple[Array, Array]:
    """What a signature claims that a lag does to the residuals, and what it does to them; whitened."""
    late = laid_out(flight, das, lag)
    whiten = noise_of_log(without).whitener(without.grid, without.residuals.slack)
    effect = EFFECTS[lag]
    sizes = effect.complete({effect.parameters[0].name: SIZE})
    claimed = residual_change(effect, without.reference, sizes)
    done = late.residuals.values - without.residuals.values
    return whiten(claimed).ravel(), whiten(done).ravel()


def test_a_flight_that_cannot_show_a_lag_does_not_claim_to() -> None:
    """At constant airspeeds a lag is worth less than 1σ; noise of a slow GPS claimed 5σ."""
    card = {"speeds_kt": [150.0, 110.0]}
    circle = fly(Case(maneuver="circle", card=card, turbulence="none", truth_seed=4711))
    without = laid_out(circle, "20/1")
    for lag in LAGS:
        claimed, done = claimed_and_done(circle, without, "20/1", lag)
        assert np.linalg.norm(done) < 2.0
        assert np.linalg.norm(claimed) < 3.0


def test_a_signature_claims_what_a_lag_does() -> None:
    """Two speeds with turns between: a lag shows what a pilot does to hold the airspeed."""
    card = {"speeds_kt": [140.0, 105.0]}
    case = Case(maneuver="four_leg", card=card, turbulence="none", pilot="good", truth_seed=4711)
    flight = fly(case)
    without = laid_out(flight, "20/5")
    for lag in LAGS:
        claimed, done = claimed_and_done(flight, without, "20/5", lag)
        assert np.linalg.norm(done) > 8.0
        # It was 0.4 and 0.7.
        assert claimed @ done / (claimed @ claimed) == pytest.approx(1.0, abs=0.2)
