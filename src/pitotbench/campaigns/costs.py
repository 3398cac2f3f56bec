"""What a campaign would fly and what it would cost, before anything is flown."""

from collections.abc import Iterator
from itertools import islice
from statistics import fmean

from pitotbench.campaigns.campaign import CampaignRequest
from pitotbench.campaigns.fleet import usable_cores
from pitotbench.campaigns.result_table import STORE
from pitotbench.campaigns.store import ResultStore
from pitotbench.campaigns.task import Task, sharded
from pitotbench.simulation.maneuvers import MANEUVERS

# Measured on one core of a server of 2024 (docs/scale.md).
CPU_SECONDS_A_MINUTE = 0.15  # of flight
CPU_SECONDS_A_CALIBRATION = 0.12  # of a data system by a model
BYTES_A_PART = 4096  # of the store, one a flight
BYTES_A_SAMPLE = 100  # of a log in Parquet
_MINUTES = 6.0  # of a maneuver that the paper does not have
_SAMPLED_TASKS = 1_000  # flights of the plan


def forecast_of_costs(request: "CampaignRequest") -> Iterator[str]:
    """Give the lines of a dry run: flights, those stored, CPU and wall minutes, gigabytes.

    The minutes are those of the stored flights of the plan, else of the paper's card of each
    maneuver.
    """
    plan = request.planned()
    part, parts = request.shard or (1, 1)
    count = len(range(part - 1, plan.count, parts))
    tasks = plan.tasks(request.log_format, request.keep_logs)
    sampled = list(islice(sharded(tasks, (part, parts)), _SAMPLED_TASKS))
    store = ResultStore(request.out / STORE)
    stored = [document for task in sampled if (document := store.find(task.key)) is not None]
    scale = count / len(sampled)
    cores = request.jobs or usable_cores()
    measured = [document["made"]["cpu_s"] for document in stored if document["rows"]]
    seconds = (
        fmean(measured) * len(sampled) if measured else sum(cpu_seconds(task) for task in sampled)
    )
    minutes = scale * seconds / 60.0
    size = scale * sum(_bytes_of_task(task) for task in sampled) / 1e9
    whole = "" if count == len(sampled) else f" of the first {len(sampled):,}"
    varied = ", ".join(plan.varied) or "seeds"
    yield f"flights: {count:,} ({len(plan.calibrations):,} calibrations each; varied: {varied})"
    yield f"stored:  {len(stored):,}{whole}"
    wall = f"{minutes / cores:,.0f} min on {cores} processes"
    yield f"time:    about {minutes:,.0f} CPU min, {wall}, if none is stored"
    yield f"disk:    about {size:,.2f} GB in {request.out}"
    yield f"first:   {sampled[0].name}; last looked at: {sampled[-1].name}"


def cpu_seconds(task: Task) -> float:
    """Return the CPU seconds that a task is expected to take."""
    fits = len(task.systems) * len(task.calibrations)
    return CPU_SECONDS_A_MINUTE * _minutes(task) + CPU_SECONDS_A_CALIBRATION * fits


def _minutes(task: Task) -> float:
    return MANEUVERS[task.case.maneuver].minutes or _MINUTES


def _bytes_of_task(task: Task) -> float:
    logs = task.systems if task.keep_logs == "all" else ()
    return BYTES_A_PART + BYTES_A_SAMPLE * sum(
        60.0 * _minutes(task) * system.air_rate for system in logs
    )
