"""Run a campaign: plan its flights, fly those that are not stored, and make the folder of its results."""

import shlex
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from pitotbench.bench.campaign.engine import fly_missing
from pitotbench.bench.campaign.perform import perform_task
from pitotbench.bench.campaign.plan import CampaignPlan, plan_of_names, seeds_of
from pitotbench.bench.campaign.plan_file import read_plan
from pitotbench.bench.campaign.published import PlanDigest, note_published, published
from pitotbench.bench.campaign.stopping import StoppedError, stoppable
from pitotbench.bench.campaign.tasks import Task, sharded
from pitotbench.bench.campaign.watching import Watch
from pitotbench.bench.code_digest import code_digest, package_digest
from pitotbench.bench.fleet import FleetLostError, Limits, open_fleet, say
from pitotbench.bench.result_table import (
    RESULTS,
    STORE,
    Gathered,
    gather,
    publish_files,
    require_own_folder,
)
from pitotbench.bench.store import DONE, Document, ResultStore, satisfies, stored
from pitotbench.calibrate import CalibrationOptions
from pitotbench.logbook import write_text
from pitotbench.records.case import Case
from pitotbench.records.case_file import write_case
from pitotbench.records.errors import NoAnswerError

GIGABYTE = 1_000_000_000
MEMORY = 2.0  # GB that a flight may use; 0.3 GB are usual
PAGE = "report.html"
_LOOKED_AT = 20  # stored flights, of which the code is compared
SECONDS = 900.0  # s that a flight may take; 1 to 10 s are usual


@dataclass(frozen=True, slots=True)
class CampaignRequest:
    """The request for a campaign, as the command line makes it. Names may be comma lists or `all`.

    `plan` is a file that says what is flown; without it the names do. `seeds` is a number, or a range such as
    `501-1000`. `shard` (k, n) flies the k-th of n parts. `time_limit` [s] and `memory_limit` [GB] are for a flight.
    `keep_logs` is `none`, `failed` or `all`. `retry_failed` flies failures again. `progress` is a style of `Watch`.
    Without `report` nothing is drawn and no page is written.
    """

    maneuvers: str = ""
    systems: str = ""
    models: str = "inverse+"
    seeds: int | str = 1
    base: Case = field(default_factory=Case)
    options: CalibrationOptions = field(default_factory=CalibrationOptions)
    out: Path = Path("out")
    jobs: int | None = None
    scheduler: str | None = None
    log_format: str = "parquet"
    plan: Path | None = None
    shard: tuple[int, int] | None = None
    security: Path | None = None
    time_limit: float | None = SECONDS
    memory_limit: float | None = MEMORY
    keep_logs: str = "all"
    retry_failed: bool = False
    progress: str = "none"
    report: bool = True

    def planned(self) -> CampaignPlan:
        """Return the plan. Raises BadInputError or UnknownNameError for a bad one."""
        if self.plan is not None:
            return read_plan(self.plan)
        seeds = seeds_of(str(self.seeds))
        plan = plan_of_names(self.base, self.maneuvers, self.systems, self.models, seeds, self.options)
        plan.check()
        return plan


@dataclass(frozen=True, slots=True)
class CampaignResult:
    """The table of results, the failures in words, and the folder of the files.

    `found` and `flown` count the flights that the store held and those of this run.
    """

    table: pd.DataFrame
    failures: tuple[str, ...]
    folder: Path
    found: int = 0
    flown: int = 0


def run_campaign(request: CampaignRequest) -> CampaignResult:
    """Fly, sense, calibrate, score and show a campaign. A flight that the folder's store holds is not flown again.

    The same request therefore goes on where an earlier run was stopped, however that was. Raises BadInputError or
    UnknownNameError for a bad request, before anything is flown; NoAnswerError where no flight gave a result;
    StoppedError, a KeyboardInterrupt, where it is asked to stop.
    """
    campaign = _Campaign(request, request.planned())
    require_own_folder(request.out)
    limits = Limits(request.time_limit, _bytes(request.memory_limit))
    with (
        stoppable(),
        open_fleet(
            request.jobs, request.scheduler, campaign.count, limits, request.security, isolated=True
        ) as fleet,
        ResultStore(request.out / STORE) as store,
    ):
        watch = Watch(campaign.count, request.progress)
        campaign.say_what_is_stored(store)
        plan = campaign.plan_digest()
        try:
            with watch.shown():
                fly_missing(plan.of(campaign.tasks()), perform_task, stored, store, fleet, watch, campaign.wanted)
        except KeyboardInterrupt as error:
            raise StoppedError(f"stopped ({str(error) or 'Ctrl-C'}); {campaign.how_to_go_on(watch)}") from error
        except FleetLostError as error:
            raise NoAnswerError(f"{error}; {campaign.how_to_go_on(watch)}") from error
        watch.finish()
        return campaign.result(store, watch, plan.hexdigest())


@dataclass(frozen=True, slots=True)
class _Campaign:
    request: CampaignRequest
    plan: CampaignPlan

    @property
    def count(self) -> int:
        """The number of flights of this shard."""
        if self.request.shard is None:
            return self.plan.count
        part, parts = self.request.shard
        return len(range(part - 1, self.plan.count, parts))

    def tasks(self) -> Iterator[Task]:
        """Give the tasks of this shard one by one."""
        tasks = self.plan.tasks(self.request.log_format, self.request.keep_logs, self.request.report)
        return sharded(tasks, self.request.shard) if self.request.shard else tasks

    def wanted(self, document: Document, task: Task) -> bool:
        """Return whether a stored result will do."""
        again = self.request.retry_failed and document["state"] != DONE
        return satisfies(document, task) and not again

    def say_what_is_stored(self, store: ResultStore) -> None:
        """Say how many flights the store holds, and how many of them are of other code."""
        if self.request.progress == "none":
            return
        keys = [*store.keys()]
        if not keys:
            return
        say(f"{self.request.out}: {len(keys):,} flights are stored; those of this plan are not flown again")
        looked = (store.find(key) for key in keys[:: max(len(keys) // _LOOKED_AT, 1)])
        if {document["made"]["code"] for document in looked if document} - {code_digest()}:
            say("the stored flights are of other code: they stay, and are flown again by this code")

    def how_to_go_on(self, watch: Watch) -> str:
        """Return what is stored and the command that goes on."""
        command = shlex.join(["pitotbench", *sys.argv[1:]] if _is_command() else [sys.argv[0], *sys.argv[1:]])
        done = watch.found + watch.flown
        return f"{done:,} of {watch.total:,} flights are stored in {self.request.out}; to go on: {command}"

    def plan_digest(self) -> PlanDigest:
        """Return the digest that tells whether the files of the folder are those of this plan and this code."""
        asked, plan = self.request, self.plan
        return PlanDigest(
            package_digest(), plan.varied, plan.seeds, asked.report, asked.keep_logs, asked.log_format
        )

    def result(self, store: ResultStore, watch: Watch, plan: str) -> CampaignResult:
        """Make the files of the folder, unless they are those of this plan already, and return the result."""
        folder = self.request.out
        known = None if watch.flown else published(folder, store, plan)
        if known is not None:
            return CampaignResult(pd.read_parquet(folder / RESULTS), known, folder, watch.found, watch.flown)
        found = gather(folder, store, self.tasks(), self.plan.varied)
        failures = tuple(found.failures)
        if found.failed > len(failures):
            failures += (f"and {found.failed - len(failures):,} more: pitotbench results {folder} --state failed",)
        if not found.rows:
            raise NoAnswerError("no flight gave a result: " + "; ".join(failures[:3]))
        if self.request.keep_logs != "none":
            publish_files(folder, store, self.tasks())
        table = pd.read_parquet(folder / RESULTS)
        if self.request.report:
            write_text(folder / PAGE, self._page(table, found, failures))
        else:
            (folder / PAGE).unlink(missing_ok=True)  # that of an earlier run, which shows another table
        note_published(folder, store, plan, failures)
        return CampaignResult(table, failures, folder, watch.found, watch.flown)

    def _page(self, table: pd.DataFrame, found: Gathered, failures: tuple[str, ...]) -> str:
        from pitotbench.show.report import campaign_page  # it loads the drawing library, which only a page needs

        first = next(self.tasks())
        seeds = max(len(self.plan.seeds), 1)
        subtitle = (
            f"{', '.join(dict.fromkeys(table.das))} Hz · {', '.join(dict.fromkeys(table.turbulence))} turbulence · "
            f"{seeds} seed{'s' if seeds > 1 else ''} · simulated flights of {first.case.aircraft}"
        )
        return campaign_page(subtitle, table, found.sections, failures, write_case(first.case))


def _is_command() -> bool:
    return Path(sys.argv[0]).name in ("pitotbench", "__main__.py")


def _bytes(gigabytes: float | None) -> int | None:
    return None if gigabytes is None else round(gigabytes * GIGABYTE)
