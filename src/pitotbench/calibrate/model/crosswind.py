"""The second equation of the vector form: the wind across the measured direction of the air velocity.

Ground velocity minus wind has no component across the velocity through the air. Attitude and flow angles give the
direction of that velocity, so the wind across it is measured without any airspeed: Vᵍ·c = W·c + gust·c. Here c is
the horizontal unit vector to the right of the airplane's path through the air. The noise is that of heading and
vanes times the airspeed. The equation does not contain the error curve. It helps to separate the wind from the
curve, which few headings alone do not.
"""

import numpy as np

from pitotbench.calibrate.model.nuisances import Nuisance, to_the_right
from pitotbench.calibrate.model.prediction import Prediction, PredictionModel
from pitotbench.calibrate.rows.blocks import Blocks
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.units import Array

# Degrees, standard deviation of a constant error of the direction. An uncalibrated vane has the error of its zero
# and that of the upwash or sidewash at its position.
DIRECTION_DEVIATION = 5.0
_PER_DEGREE = np.pi / 180.0


def direction_nuisances() -> tuple[Nuisance, ...]:
    """The constant errors of the direction: of heading and sideslip vane, and of the angle of attack.

    That of the angle of attack has an effect in a bank only. Neither changes the predicted airspeed.
    """
    return (
        Nuisance("direction_deg", DIRECTION_DEVIATION, _nothing, _by_direction),
        Nuisance("direction_in_bank_deg", DIRECTION_DEVIATION, _nothing, _by_direction_in_bank),
    )


def crosswind(
    model: PredictionModel,
    nuisances: tuple[Nuisance, ...],
    prediction: Prediction,
    obs: Observations,
    blocks: Blocks,
    theta: Array,
) -> tuple[Array, Array]:
    """Return response (blocks,) [m/s] and regressors (blocks, p + m) of the wind to the right.

    They are linearized at θ (p,); m is the number of nuisances.
    """
    right = to_the_right(obs)
    first = model.error_count
    wind = theta[first : first + 2]
    ground = np.stack([obs.velocity_north, obs.velocity_east], axis=1)
    regressors = np.zeros((len(obs), model.count + len(nuisances)))
    regressors[:, first : first + 2] = right
    for place, nuisance in enumerate(nuisances, start=model.count):
        if nuisance.across is not None:
            regressors[:, place] = nuisance.across(prediction, obs)
    return blocks.mean(np.sum((ground - wind) * right, axis=1)), blocks.mean(regressors)


def _nothing(prediction: Prediction, obs: Observations) -> Array:
    return np.zeros(len(obs))


def _by_direction(prediction: Prediction, obs: Observations) -> Array:
    return _PER_DEGREE * prediction.true_airspeed


def _by_direction_in_bank(prediction: Prediction, obs: Observations) -> Array:
    assert obs.bank is not None
    return _PER_DEGREE * prediction.true_airspeed * np.sin(obs.bank)
