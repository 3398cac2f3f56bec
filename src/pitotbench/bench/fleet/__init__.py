"""Run many flights: in this process, in spawned processes, through any executor, or on a dask cluster.

A task is all the work on one flight. A task that fails is reported in words and the other tasks go on. A task whose
process dies is performed once more, alone, and is then put in quarantine.
"""

from pitotbench.bench.fleet.failure import Failure as Failure
from pitotbench.bench.fleet.failure import FleetLostError as FleetLostError
from pitotbench.bench.fleet.failure import require_all as require_all
from pitotbench.bench.fleet.opening import open_fleet as open_fleet
from pitotbench.bench.fleet.opening import progress as progress
from pitotbench.bench.fleet.opening import run_tasks as run_tasks
from pitotbench.bench.fleet.task_limits import Limits as Limits
from pitotbench.bench.fleet.task_stream import Fleet as Fleet
from pitotbench.bench.fleet.task_stream import Step as Step
