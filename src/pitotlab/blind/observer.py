"""The ideal observer: it knows every form, the noise and the prior, and shows how much of the truth
a log holds.

Its candidates are no effect, every cause of the table in each form that the generator has, and
every fault outside the table, each with the signature that the generator's own flights have in this
setting. Where the truth acts in a part of the flight, it also knows which part. Sizes are unknown:
of either sign, log-uniform in strength. Logs with one effect or none are observed; of a case of
several flights, each flight, and the products.
"""

import json
from argparse import ArgumentParser
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from scipy.special import logsumexp

from pitotbench.logbook.reading import read_log
from pitotbench.units import Array
from pitotlab.blind.drawn import PARTIAL, cause_of
from pitotlab.blind.outsiders import OUTSIDERS, Part
from pitotlab.blind.sealed import PLACE
from pitotlab.blind.signatures import layout_of, matched, noise_of, read, segments_at

NONE = "none"
PRIOR = {NONE: 0.3, "table": 0.6, "outside": 0.1}
WEAKEST, STRONGEST, POINTS = 2.0, 600.0, 6000  # σ, of the prior of a strength
LEAST_SEEN = 0.02  # share of a signature that wind, curve and biases must leave
TOLD = 8  # causes in a line of the results


def without_free(columns: Array, free: Array, deviations: Array) -> Array:
    """Return the inner products of whitened columns (m, k) with free parameters (m, f) of prior
    deviations out.

    This is C'(I + F D² F')⁻¹C by Woodbury's identity: the free parameters are noise of known
    covariance.
    """
    normal = free.T @ free + np.diag(1.0 / deviations**2)
    across = free.T @ columns
    return np.asarray(columns.T @ columns - across.T @ np.linalg.solve(normal, across))


def log_evidence(filtered: Array, prior: Array | None = None) -> Array:
    """Return ln of the mean likelihood ratio against none, for matched-filter outputs [σ], (k,).

    A strength x of the signature gives exp(x t − x²/2); x is of either sign and log-uniform.
    """
    strength = np.geomspace(WEAKEST, STRONGEST, POINTS) if prior is None else prior
    both = np.concatenate([strength, -strength])
    ratios = both[None, :] * filtered[:, None] - 0.5 * both[None, :] ** 2
    return np.asarray(logsumexp(ratios, axis=1) - np.log(len(both)))


def probabilities(evidence: Mapping[str, Sequence[float]]) -> dict[str, float]:
    """Return the probability of each cause, and of none, from the evidence of each of its forms."""
    outside = [c for c in evidence if c in OUTSIDERS]
    each = {c: PRIOR["outside"] / len(outside) if c in OUTSIDERS else 0.0 for c in evidence}
    inside = [c for c in evidence if c not in OUTSIDERS]
    each |= {c: PRIOR["table"] / len(inside) for c in inside}
    weights = {c: np.log(each[c]) + logsumexp(v) - np.log(len(v)) for c, v in evidence.items()}
    weights[NONE] = np.log(PRIOR[NONE])
    whole = logsumexp(list(weights.values()))
    found = {c: float(np.exp(w - whole)) for c, w in weights.items()}
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def filtered(path: Path, letter: str, part: tuple[float, float] | None) -> dict[str, list[float]]:
    """Return the matched-filter outputs [σ] of each cause's forms on one log."""
    log, signatures, noise = read_log(path), read(letter), noise_of(letter)
    layout = layout_of(log)
    time = layout.track.time[layout.grid.rows]
    values, segments = np.moveaxis(signatures.values, 0, 2), np.array(signatures.segment)
    moved = matched(values, segments, segments_at(log, time))  # (n, c, e)
    names = list(signatures.names)
    if part is not None:
        acting = Part(*part)(time - layout.track.time[0])
        inside = [i for i, name in enumerate(names) if name in PARTIAL]
        moved = np.concatenate([moved, moved[:, :, inside] * acting[:, None, None]], axis=2)
        names += [names[i] for i in inside]
    whiten = noise.whitener(layout.grid, layout.residuals.slack)
    count = moved.shape[0] * moved.shape[1]
    columns = np.concatenate([moved, layout.residuals.values[:, :, None]], axis=2)
    white = whiten(columns).reshape(count, -1)
    free = whiten(layout.free.columns).reshape(count, -1)
    inner = without_free(white, free, layout.free.deviations)
    power, whole = np.diag(inner)[:-1], np.sum(white[:, :-1] ** 2, axis=0)
    found: dict[str, list[float]] = {}
    for name, own, before, product in zip(names, power, whole, inner[:-1, -1], strict=True):
        if own > LEAST_SEEN**2 * before and own > 0.0:
            found.setdefault(cause_of(name), []).append(float(product / np.sqrt(own)))
    return found


def observed(case: Mapping[str, Any]) -> dict[str, Any]:
    """Observe the flights of a case; returns a line of the results."""
    begun = process_time()
    parts = [tuple(e["part"]) for e in case["effects"] if e["part"]]
    part = parts[0] if parts else None
    summed: dict[str, list[float]] = {}
    for flight, letter in enumerate(case["settings"]):
        path = PLACE / "logs" / f"{case['name']}{('', '-b', '-c')[flight]}.parquet"
        outputs = filtered(path, letter, part)
        seen = {c: log_evidence(np.array(t)).tolist() for c, t in outputs.items()}
        # Sizes of several flights are taken as free of each other: a little less than an ideal
        # observer knows.
        summed = seen if not flight else {c: _sums(summed[c], seen[c]) for c in summed if c in seen}
    found = probabilities(summed)
    told = {c: round(p, 5) for c, p in list(found.items())[:TOLD]}
    causes = {cause_of(e["name"]) for e in case["effects"]}
    told |= {c: round(found.get(c, 0.0), 5) for c in causes}
    spent = round(process_time() - begun, 2)
    return {"name": case["name"], "probabilities": told, "processor_s": spent}


def _sums(one: Sequence[float], other: Sequence[float]) -> list[float]:
    """Evidence of the same forms on two flights; of different numbers of forms, each with each."""
    if len(one) == len(other):
        return [a + b for a, b in zip(one, other, strict=True)]
    return [a + b for a in one for b in other]


def observe(jobs: int) -> None:
    """Observe every case with one effect or none that has no line in the results yet."""
    results = PLACE / "observed.jsonl"
    cases = json.loads((PLACE / "seal" / "truth.json").read_text("utf-8"))["cases"]
    lines = results.read_text("utf-8").splitlines() if results.is_file() else []
    done = {json.loads(line)["name"] for line in lines}
    todo = [c for c in cases if c["kind"] not in ("two", "counted") and c["name"] not in done]
    results.parent.mkdir(parents=True, exist_ok=True)
    with (
        ProcessPoolExecutor(jobs, get_context("spawn")) as pool,
        results.open("a", encoding="utf-8") as out,
    ):
        work = [pool.submit(observed, case) for case in todo]
        for number, job in enumerate(as_completed(work), start=1):
            out.write(json.dumps(job.result()) + "\n")
            out.flush()
            if number % 20 == 0 or number == len(todo):
                print(f"observed: {number} of {len(todo)}", flush=True)


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Give the answer of the ideal observer on every case of one effect or none."""
    parser.add_argument("--jobs", type=int, default=2)
    observe(parser.parse_args(words).jobs)
