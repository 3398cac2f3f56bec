"""Force a wrong effect into named cases: how much of the gap of the flight held out it closes.

python -m tests.blind.forced --logs out/blind/logs --results out/blind/results.jsonl --seal out/blind/seal
The cases are those of one flight with one effect that was named rightly and of which another flight was held out.
Into each, `--wrong` effects are forced one after the other at the sizes that fit the log best. They are drawn among
those that improve the log at a plausible size, and whose cause is neither the hidden one nor left by the answer.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from tests.blind.case import JudgedCase, model_of
from tests.blind.score import judged_cases

from pitotbench.bench.reconcile.aircraft_models import aircraft_model
from pitotbench.bench.reconcile.reconciliation import reconcile_log
from pitotbench.logbook import read_log
from pitotbench.reconcile.decide.judgment import hold_out
from pitotbench.reconcile.decide.scoring import significance
from pitotbench.reconcile.decide.sizes import is_in_range
from pitotbench.reconcile.signatures.hypotheses import returns
from pitotbench.reconcile.signatures.signatures import columns_of

SEEN = 3.0  # σ by which a wrong effect improves the log that it is forced into; one of no gain is forced by nobody
CLOSES = 0.3  # share of the gap held out that a wrong effect must not close


def forced(logs: Path, cases: Sequence[JudgedCase], wrong: int) -> Iterator[Mapping[str, Any]]:
    """The share of the gap of the flight held out that each forced effect closes, beside that of the named one."""
    for case in cases:
        name = case.truth["name"]
        held = logs / f"{name}-held.parquet"
        if case.flights != 1 or not case.named or len(case.wanted) != 1 or not held.is_file():
            continue
        found, other = reconcile_log(read_log(logs / f"{name}.parquet"), "navajo"), read_log(held)
        naming, aircraft = found.naming, aircraft_model("navajo")
        signatures = naming.layout.signatures
        fits = {n: naming.equations.fit(own) for n, own in columns_of(signatures).items() if returns(n)}
        fits = {n: fit for n, fit in fits.items() if is_in_range(signatures, fit)}
        likely = {model_of(c) for c, p in naming.answer.probabilities.items() if p > 0.01}
        open_to = [n for n, f in fits.items() if significance(f) > SEEN and model_of(n) not in case.wanted | likely]
        random = np.random.default_rng(crc32(name.encode()))
        for effect in random.permutation(open_to)[:wrong].tolist():
            wrongly = replace(naming, chosen=(effect,), fit=fits[effect])
            closed = hold_out(other, aircraft, found.null, wrongly, found.layout.setting)
            yield {
                "case": name,
                "effect": case.truth["effects"][0]["name"],
                "forced": effect,
                "significance": round(significance(fits[effect]), 1),
                "closure": round(closed.share, 3),
                "named": case.answer.get("held_out"),
            }


if __name__ == "__main__":
    place, judged, asked = judged_cases(__doc__, "--wrong", 4)
    below = 0
    for count, line in enumerate(forced(place, judged, asked), start=1):
        below += line["closure"] < CLOSES
        print(json.dumps(line), f"below {CLOSES}: {below} of {count}", flush=True)
