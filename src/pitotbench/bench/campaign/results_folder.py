"""Where a campaign's results go: a folder that appears whole or not at all."""

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import mkdtemp

import pandas as pd

from pitotbench.bench.campaign.perform import Row, TaskOutcome
from pitotbench.records.errors import BadInputError
from pitotbench.units import KNOT

RESULTS = "results.parquet"


@contextmanager
def appearing_folder(target: Path) -> Iterator[Path]:
    """A scratch folder beside `target` that becomes it at the end, and is removed where something fails.

    An earlier campaign's folder is replaced; any other existing folder is refused with BadInputError.
    """
    if target.exists() and (not target.is_dir() or (any(target.iterdir()) and not (target / RESULTS).exists())):
        raise BadInputError(f"{target} exists and holds no campaign's results; choose another --out")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        scratch = Path(mkdtemp(prefix=f".{target.name}-", dir=target.parent))
    except OSError as error:
        raise BadInputError(f"{target}: cannot be made: {error.strerror or error}; choose another --out") from error
    try:
        yield scratch
        scratch.chmod(0o755)
        _replace(target, scratch)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _replace(target: Path, scratch: Path) -> None:
    """Put the new folder in place of an earlier one, which is deleted only once the new one stands."""
    earlier = scratch.with_name(f"{scratch.name}-earlier")
    if target.exists():
        target.rename(earlier)
    scratch.rename(target)
    shutil.rmtree(earlier, ignore_errors=True)


def results_table(outcomes: Sequence[TaskOutcome]) -> pd.DataFrame:
    """One row a maneuver, data system, model and seed; units in the column names."""
    return pd.DataFrame([_columns(row) for outcome in outcomes for row in outcome.rows])


def _columns(row: Row) -> dict[str, object]:
    score = row.score
    return {
        "maneuver": row.maneuver,
        "das": row.das,
        "model": row.model,
        "seed": row.seed,
        "turbulence": row.turbulence,
        "minutes": score.minutes,
        "samples": score.samples,
        "residual_two_sigma_kt": score.residual_two_sigma / KNOT,
        "two_sigma_kt": score.two_sigma / KNOT,
        "curve_rms_error_kt": score.curve_rms_error / KNOT,
        "wind_error_kt": score.wind_error / KNOT,
        "curve_coverage": score.curve_coverage,
        "on_condition_share": score.on_condition_share,
    }
