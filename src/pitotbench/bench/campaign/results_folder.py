"""The folder of a campaign's results. It appears complete or not at all."""

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
    """Give a scratch folder next to `target`. It is renamed to `target` at the end, and removed after an error.

    The folder of an earlier campaign is replaced. Raises BadInputError for any other existing folder.
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
    """Put the new folder in place of an earlier one. The earlier one is deleted only after that."""
    earlier = scratch.with_name(f"{scratch.name}-earlier")
    if target.exists():
        target.rename(earlier)
    scratch.rename(target)
    shutil.rmtree(earlier, ignore_errors=True)


def results_table(outcomes: Sequence[TaskOutcome]) -> pd.DataFrame:
    """Return one row for each maneuver, data system, model and seed. The column names end in units."""
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
