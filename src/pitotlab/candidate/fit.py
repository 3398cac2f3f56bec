"""The fit of one calibration problem: relinearized to its answer, its noise marginalized once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from pitotbench.calibration.covering import Posterior
from pitotbench.calibration.observations import Blocks, block_length, divide
from pitotbench.calibration.prediction import wind_by_circle
from pitotbench.records import NoAnswerError
from pitotbench.units import Array
from pitotlab.candidate.heights import altitude_guess
from pitotlab.candidate.jumps import WithJump, evenly, jump_columns
from pitotlab.candidate.linear_gaussian import (
    LinearGaussian,
    Mode,
    Normal,
    Search,
    Surface,
    drawn,
    mode_of,
    with_curvature,
)
from pitotlab.candidate.triangle import Triangle, height_equations, triangle
from pitotlab.candidate.unknowns import UNKNOWN, Unknowns

SEARCH = Search()
_PASSES = 16
_WHOLE_STEPS = 4  # passes after which a step that may swing to and fro is halved
_SETTLED, _ROUGHLY = 0.1, 0.3  # gain in log-posterior of the last step, fine and coarse
_CLEARLY = 3.0  # log odds by which another hypothesis takes over the search
_NEAR = 1.0  # standard errors
_HEAVIEST, _COVERED = 8, 0.9  # nodes by which the equations are compared; their weight
_JUMP_TIMES = 24


@dataclass(frozen=True, slots=True)
class WindFit:
    """The wind of one flight: its mean, (2,) with covariance (2, 2).

    `change` is the largest difference of a component between two times [m/s], `jump` the
    probability of a front and `jump_time` its likeliest time [s].
    """

    mean: Array
    covariance: Array
    change: float
    jump: float
    jump_time: float


@dataclass(frozen=True, slots=True)
class Fit:
    """The answer: β as a mixture of normals, the likeliest noise, the wind of each flight.

    `noise` (d,) are the sizes of the noise at the mode. `agreement` is the probability of so large
    a difference between triangle and heights by chance, None without heights. `unknown` is the
    probability of an uncalibrated impact-pressure system. `blocks` counts the block means.
    """

    unknowns: Unknowns
    posterior: Posterior
    noise: Array
    winds: tuple[WindFit, ...]
    agreement: float | None
    unknown: float
    blocks: int


@dataclass(frozen=True, slots=True)
class _Point:
    """The problem linearized at one place."""

    problem: LinearGaussian
    triangles: tuple[Triangle, ...]


def _linearize(
    unknowns: Unknowns,
    blocks: Sequence[Blocks],
    beta: Array,
    gusts: Sequence[float],
) -> _Point:
    triangles = tuple(
        triangle(unknowns, flight, own, beta, gust)
        for flight, own, gust in zip(unknowns.flights, blocks, gusts, strict=True)
    )
    equations = [each.equations for each in triangles]
    equations += [
        height_equations(unknowns, flight, beta)
        for flight in unknowns.flights
        if flight.heights is not None
    ]
    return _Point(
        LinearGaussian(equations, unknowns.count, unknowns.hypotheses(), unknowns.log_prior),
        triangles,
    )


@dataclass(frozen=True, slots=True)
class Approach:
    """The answer of the coarse passes: β (p,), the mode of φ, the likeliest hypothesis, and the
    size of the gusts of each flight [m/s].
    """

    beta: Array
    mode: Mode
    best: int
    gusts: list[float]


def approach(unknowns: Unknowns) -> Approach:
    """Move β to the answer, on blocks twice as long as the last.

    Raises NoAnswerError where the log is too short, the fit leaves the model's domain or the passes
    do not settle.
    """
    flights = unknowns.flights
    beta = np.zeros(unknowns.count)
    for flight in flights:
        beta[flight.winds] = wind_by_circle(flight.observations)
    coarse = [divide(f.observations, 2.0 * block_length(f.observations)) for f in flights]
    _require_enough(unknowns, coarse)
    near: Mode | Array = _guess(unknowns)
    gusts, best = [0.0] * len(flights), 0
    tried = {best}
    for number in range(_PASSES):
        point = _linearize(unknowns, coarse, beta, gusts)
        near = mode_of(point.problem, near, SEARCH, _ROUGHLY, best)
        place = near.place
        found, covariance = point.problem.solve(place, best)
        step = found - beta
        beta = beta + (step if number < _WHOLE_STEPS else 0.5 * step)
        gusts = [float(np.exp(place[flight.triangle.start])) for flight in flights]
        if np.all(np.abs(step) < _NEAR * np.sqrt(np.diag(covariance))):
            rivals = range(len(unknowns.rivals))
            heights = [float(point.problem.heights(place[None], h)[0]) for h in rivals]
            likeliest = int(np.argmax(heights))
            if heights[likeliest] > heights[best] + _CLEARLY and likeliest not in tried:
                best = likeliest
                tried.add(best)
                continue
            exact = with_curvature(point.problem, near, SEARCH, best)
            return Approach(beta, exact, best, gusts)
    raise NoAnswerError(
        "the fit does not settle: check the log for gross errors, or choose a simpler model"
    )


def fit(unknowns: Unknowns) -> Fit:
    """Fit a problem: linearize it at its answer, and marginalize the noise there.

    Raises as `approach` does.
    """
    flights, near = unknowns.flights, approach(unknowns)
    fine = [divide(f.observations, block_length(f.observations)) for f in flights]
    point = _linearize(unknowns, fine, near.beta, near.gusts)
    place = mode_of(point.problem, near.mode, SEARCH, _SETTLED, near.best).place
    mode = Mode(place, near.mode.curvature)
    steady: tuple[Surface, Mode] = (point.problem, mode)
    changed = []
    for number in range(len(flights)):
        surface = _with_jump(unknowns, point, number)
        own = mode_of(surface, mode, SEARCH, _ROUGHLY, near.best)
        changed.append((surface, with_curvature(surface, own, SEARCH, near.best)))
    nodes, shares = drawn([steady, *changed], SEARCH, near.best, len(flights) == 1)
    agreement = _agreement(point, nodes)
    times = [surface.likeliest_time(own.place, near.best) for surface, own in changed]
    winds = tuple(
        _wind_of(unknowns, point, number, nodes, (float(shares[number + 1]), time))
        for number, time in enumerate(times)
    )
    chance = sum(n.weight for n in nodes if unknowns.rivals[n.hypothesis][0] == UNKNOWN)
    count = sum(len(each.count) for each in fine)
    return Fit(unknowns, _posterior(nodes), np.exp(place), winds, agreement, float(chance), count)


def _posterior(nodes: Sequence[Normal]) -> Posterior:
    return Posterior(
        np.array([node.weight for node in nodes]),
        np.stack([node.mean for node in nodes]),
        np.stack([node.covariance for node in nodes]),
    )


def _require_enough(unknowns: Unknowns, blocks: Sequence[Blocks]) -> None:
    for flight, own in zip(unknowns.flights, blocks, strict=True):
        needed = len(unknowns.static) + len(unknowns.total) + 2 + flight.slow.stop
        if len(own.count) <= min(needed, 2 + 2 * len(unknowns.static)):
            time = flight.observations.time
            raise NoAnswerError(
                f"by its clock the log lasts {time[-1] - time[0]:.3g} s, too short for an answer: "
                "check the unit of the time, or fly longer"
            )


def _guess(unknowns: Unknowns) -> Array:
    place = np.log(unknowns.medians()[:, 0])
    for flight in unknowns.flights:
        if flight.heights is not None:
            place[flight.height] = altitude_guess(flight.heights.rows)
    return np.asarray(place)


def _heaviest(nodes: Sequence[Normal]) -> list[Normal]:
    """The heaviest nodes, which hold most of the weight."""
    ordered = sorted(nodes, key=lambda node: -node.weight)
    held = np.cumsum([node.weight for node in ordered])
    return ordered[: min(_HEAVIEST, int(np.searchsorted(held, _COVERED)) + 1)]


def _with_jump(unknowns: Unknowns, point: _Point, number: int) -> WithJump:
    """The rival of a steady wind: one jump of the wind of a flight."""
    priors, own = unknowns.priors, point.triangles[number]
    time = own.blocks.mean(unknowns.flights[number].observations.time)
    times = evenly(time, _JUMP_TIMES)
    columns = jump_columns(own.along, time, times, priors.jump_seconds, own.blocks.count)
    return WithJump(point.problem, number, times, columns, priors.jump, priors.jump_odds)


def _wind_of(
    unknowns: Unknowns,
    point: _Point,
    number: int,
    nodes: Sequence[Normal],
    jump: tuple[float, float],
) -> WindFit:
    """The mean wind of a flight, and how much the slow wind changes."""
    flight, own = unknowns.flights[number], point.triangles[number]
    obs, posterior = flight.observations, _posterior(nodes)
    share = own.blocks.count / own.blocks.count.sum()
    layers = share @ own.blocks.mean(flight.shear_basis(obs.height()))
    slow = own.blocks.mean(flight.slow_basis(obs.time))
    rows = np.zeros((2, unknowns.count))
    rows[[0, 1], flight.winds] = 1.0
    for axis, (name, places) in enumerate(zip(("north", "east"), flight.slow_places, strict=True)):
        rows[axis, [flight.at[f"shear_{name}_{i}"] for i in range(len(layers))]] = layers
        rows[axis, places] = share @ slow
    paths = [slow @ posterior.mean[places] for places in flight.slow_places]
    mean, covariance = rows @ posterior.mean, rows @ posterior.covariance @ rows.T
    return WindFit(mean, covariance, float(max(np.ptp(path) for path in paths)), *jump)


_LEAST_GAINED = 0.01  # share of a variance: of a direction that gains less, small errors decide


def _agreement(point: _Point, nodes: Sequence[Normal]) -> float | None:
    """The probability of so large a difference between the heights and the triangles by chance.

    The triangles' answer is the prior of the heights' equations: what these move it by is compared
    with what it may be moved by, under each likely noise (Box, Journal of the Royal Statistical
    Society A 143, 1980).
    """
    problem, count = point.problem, len(point.triangles)
    if len(problem.equations) == count:
        return None
    found = []
    heaviest = _heaviest(nodes)
    for node in heaviest:
        prior = problem.hypotheses[node.hypothesis].precision_of(node.noise[None])[0]
        first = LinearGaussian(
            problem.equations[:count], problem.count, problem.hypotheses, problem.log_prior
        ).information(node.noise)
        second = LinearGaussian(
            problem.equations[count:], problem.count, problem.hypotheses, problem.log_prior
        ).information(node.noise)
        flat = (prior == 0.0) & (np.diag(first[0]) == 0.0)  # unknowns of the heights alone
        shared = ~flat
        found.append(node.weight * _chance(first, second, prior, shared, flat))
    return float(sum(found) / sum(node.weight for node in heaviest))


def _chance(
    first: tuple[Array, Array],
    second: tuple[Array, Array],
    prior: Array,
    shared: Array,
    flat: Array,
) -> float:
    """The tail probability for two sets of information, (p, p) and (p,), on the shared unknowns."""
    a, pull = second
    if flat.any():  # eliminate what only the heights hold
        inner = np.linalg.inv(a[np.ix_(flat, flat)])
        crossed = a[np.ix_(shared, flat)] @ inner
        a, pull = (
            a[np.ix_(shared, shared)] - crossed @ a[np.ix_(flat, shared)],
            pull[shared] - crossed @ pull[flat],
        )
    else:
        a, pull = a[np.ix_(shared, shared)], pull[shared]
    precision = first[0][np.ix_(shared, shared)] + np.diag(prior[shared])
    scale = 1.0 / np.sqrt(np.diag(precision))
    known = np.linalg.inv(precision * np.outer(scale, scale)) * np.outer(scale, scale)
    values, vectors = np.linalg.eigh(known / np.outer(scale, scale))
    root = scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    gained, axes = np.linalg.eigh(root.T @ a @ root)  # information in units of the prior's
    moved = gained / (1.0 + gained) > _LEAST_GAINED
    if not moved.any():
        return 1.0
    score = (root @ axes).T @ (pull - a @ (known @ first[1][shared]))
    distance = float(np.sum(score[moved] ** 2 / (gained[moved] * (1.0 + gained[moved]))))
    return float(chdtrc(int(moved.sum()), distance))
