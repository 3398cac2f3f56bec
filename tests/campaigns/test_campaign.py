"""Campaigns: the contract's columns, the same results however they are run, and what a failure
leaves behind.
"""

import json
import re
import shutil
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from importlib import import_module
from multiprocessing import get_context

import numpy as np
import pandas as pd
import pytest

from pitotbench import BadInputError, CampaignRequest, Case, NoAnswerError, run_campaign
from pitotbench.campaigns.plan_file import plan_of_names
from pitotbench.campaigns.result_table import _entries, write_page
from pitotbench.cli.app import main
from pitotbench.records.case_file import case_columns
from pitotbench.show.campaign import campaign_tree, means_of
from pitotbench.show.tree import Table
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.aircraft_files import load_fdm

COLUMNS = [
    "maneuver", "das", "model", "seed", "turbulence", "minutes", "samples", "residual_two_sigma_kt", "two_sigma_kt",
    "curve_rms_error_kt", "wind_error_kt", "curve_coverage", "on_condition_share",
]  # fmt: skip


SHORT = Case(
    card={"speeds_kt": [130.0, 110.0], "dwells_s": [10.0, 10.0], "settle_s": 2.0},
    integration_rate=40.0,
)


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    out = tmp_path_factory.mktemp("campaign") / "one"
    base = Case(card={"dwell_s": 10.0, "settle_s": 2.0}, integration_rate=40.0)
    request = CampaignRequest(
        "rapid_decel", "20/1,20/5", "inverse+,bias", base=base, seeds=2, out=out, jobs=1
    )
    return request, run_campaign(request)


def test_the_folder_holds_results_with_the_columns_of_the_contract_logs_cases_and_a_page(small):
    _, result = small
    stored = pd.read_parquet(result.folder / "results.parquet")
    assert list(stored.columns)[: len(COLUMNS)] == COLUMNS
    assert len(stored) == 2 * 2 * 2
    assert stored.notna().all().all()
    assert len(list((result.folder / "logs").glob("*.parquet"))) == 4
    assert len(list((result.folder / "cases").glob("*.toml"))) == 2
    page = (result.folder / "report.html").read_text(encoding="utf-8")
    assert page.count("<svg") == 3  # which maneuver and how long, and the curves by data system
    assert not re.search(
        r"<script|src=|http://(?!www\.w3\.org|purl\.org|creativecommons\.org)", page
    )


def test_the_report_begins_with_all_flights_and_a_page_is_drawn_when_asked_for(small, tmp_path):
    _, result = small
    report = (result.folder / "report.html").read_text(encoding="utf-8")
    assert report.index("How well the curve is known") < report.index("<table")
    assert "Ground track" not in report
    path, differences = write_page(result.folder / "rapid_decel-seed2", tmp_path / "page.html")
    page = path.read_text(encoding="utf-8")
    assert differences == ()
    assert page.count("Ground track") >= 1
    assert "rapid decel 20/5" in page
    with pytest.raises(BadInputError, match="no stored flight"):
        write_page(result.folder / "rapid_decel-seed3", None)


def test_processes_and_a_page_change_nothing(small, tmp_path):
    request, result = small
    again = run_campaign(replace(request, out=tmp_path / "two", jobs=2, report=False))
    pd.testing.assert_frame_equal(result.table, again.table, check_exact=True)
    assert not (again.folder / "report.html").exists()


def _of_its_own(work, *given):
    """What a process of its own answers: a client of dask leaves its threads behind, and what crashes
    there later takes the other tests of this process along.
    """
    pytest.importorskip("distributed", reason="dask.distributed is an extra")
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
        return process.submit(work, *given).result()


def _on_a_cluster(request):
    local = {
        "n_workers": 1,
        "threads_per_worker": 1,
        "dashboard_address": None,
        "host": "127.0.0.1",
    }
    with import_module("distributed").LocalCluster(**local) as cluster:
        return run_campaign(replace(request, scheduler=cluster.scheduler_address)).table


def test_a_cluster_changes_nothing(small, tmp_path):
    request, result = small
    again = _of_its_own(_on_a_cluster, replace(request, out=tmp_path / "dask", report=False))
    pd.testing.assert_frame_equal(result.table, again, check_exact=True)


def _without_a_cluster(out):
    distributed = import_module("distributed")
    client = distributed.Client
    distributed.Client = lambda at, timeout, security: client(at, timeout="1s")
    run_campaign(CampaignRequest("circle", "20/1", out=out, scheduler="tcp://127.0.0.1:1"))


def test_a_scheduler_that_does_not_answer_is_bad_input(tmp_path):
    with pytest.raises(BadInputError, match="scheduler"):
        _of_its_own(_without_a_cluster, tmp_path / "x")
    assert not (tmp_path / "x").exists()


def test_a_flight_alone_has_its_page_at_once_and_stays_where_a_new_campaign_fails(small, tmp_path):
    request, _ = small
    out = tmp_path / "keep"
    first = run_campaign(replace(request, out=out, seeds=1, systems="20/1"))
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "Ground track" in page
    assert "--page" not in page
    impossible = replace(request.base, card={"speeds_kt": [400.0]})
    with pytest.raises((NoAnswerError, BadInputError)):
        run_campaign(CampaignRequest("circle", "20/1", base=impossible, out=out, jobs=1))
    pd.testing.assert_frame_equal(pd.read_parquet(out / "results.parquet"), first.table)
    assert [p.name for p in tmp_path.iterdir()] == ["keep"]


def test_one_task_is_one_flight(small):
    request, _ = small
    tasks = [*plan_of_names(Case(), "all", "all", "all", range(1, 4), request.options).tasks()]
    assert len(tasks) == 5 * 3
    assert len({(t.case.maneuver, t.case.truth_seed) for t in tasks}) == 15


WINDS = """
das = ["2/1"]
[case]
maneuver = "decel_circle"
card = { speeds_kt = [130.0, 110.0], dwells_s = [10.0, 10.0], settle_s = 2.0 }
integration_rate_hz = 40
[grid]
"wind.speed_mps" = [0, 10]
[[calibrate]]
[[calibrate]]
label = "paper"
method = "paper"
"""


def test_what_a_plan_varies_is_never_pooled(tmp_path, capsys):
    """Wind, in the unit of the plan, and calibration: on the terminal, the page, in Python, and in the
    means that are written.
    """
    plan, out = tmp_path / "winds.toml", tmp_path / "out"
    plan.write_text(WINDS)
    assert main(["campaign", str(plan), "--out", str(out), "--jobs", "1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    head = next(number for number, line in enumerate(lines) if "─" in line)
    assert len([line for line in lines[head:] if line.startswith("decel circle")]) == 4
    assert "calibration    [m/s]" in lines[head - 1]
    assert [line[:19] for line in lines[:2]] == ["Wind speed 0 m/s: D", "Wind speed 10 m/s: "]
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "wind speed<br>[m/s]" in page
    found = run_campaign(CampaignRequest(plan=plan, out=out, report=False)).means
    assert found["wind.speed_mps"].tolist() == [0.0, 0.0, 10.0, 10.0]
    assert found["two_sigma_kt"].nunique() == 4
    means = tmp_path / "means.csv"
    assert main(["results", str(out), "--by", "wind.speed_kt", "--out", str(means)]) == 0
    assert len(pd.read_csv(means)) == 2
    assert main(["results", str(out), "--by", "maneuver"]) == 0
    assert "mean over several values of calibration, wind.speed_kt" in capsys.readouterr().out
    assert main(["results", str(out)]) == 0
    assert "wind.speed_kt" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("path", "found"),
    [
        ("fuel", {"fuel": 0.5}),
        ("altitude_m", {"altitude_m": 1828.8}),
        ("effects.0.parameters.latency_s", {"effects.0.parameters.latency_s": 0.4}),
        ("effects.1.name", {"effects.1.name": None}),
        ("wind", {"wind.speed_kt": 15.0, "wind.from_direction_deg": 300.0, "wind.up_mps": 0.0}),
        ("card.dwell_s", {"card.dwell_s": None}),
    ],
)
def test_a_field_of_a_plan_has_its_column_however_it_is_written(path, found):
    effects = [{"name": "gps_latency", "parameters": {"latency_s": 0.4}}]
    columns = case_columns(replace(Case(), fuel=0.5)) | {"effects": json.dumps(effects)}
    assert dict(_entries(columns, path)) == pytest.approx(found)


def test_random_values_are_averaged_and_said(small):
    table = small[1].table
    drawn = table.assign(fuel=np.linspace(0.5, 1.0, len(table)))
    assert len(means_of(drawn, ("fuel",))) == len(small[1].means) == 4
    assert len(means_of(drawn)) == len(table)
    (shown,) = (n for n in campaign_tree(drawn, drawn=("fuel",)) if isinstance(n, Table))
    assert shown.title == "against the truth, the mean over seeds and fuel"


def test_a_cache_that_is_deleted_during_a_campaign_costs_no_flight(tmp_path, monkeypatch):
    """The airplanes of a campaign are made again where their files are gone, and no flight is
    stored as failed.
    """
    monkeypatch.setenv("PITOTBENCH_CACHE", str(tmp_path / "cache"))
    shutil.copytree(find_aircraft("navajo"), tmp_path / "mine" / "navajo")
    base = replace(SHORT, aircraft=str(tmp_path / "mine" / "navajo"))
    request = CampaignRequest(
        "decel_circle", "2/1", base=base, out=tmp_path / "out", jobs=1, report=False
    )
    first = run_campaign(request)
    shutil.rmtree(tmp_path / "cache")
    second = run_campaign(replace(request, seeds="2-2"))
    shutil.rmtree(tmp_path / "cache")
    both = run_campaign(replace(request, seeds=2))
    assert (first.failures, second.failures, both.failures) == ((), (), ())
    assert (second.flown, both.found, both.flown) == (1, 2, 0)


def test_files_that_vanish_while_jsbsim_reads_them_are_no_fault_of_the_case(tmp_path):
    with pytest.raises(FileNotFoundError, match="deleted while it was read"):
        load_fdm("gone", tmp_path / "gone", 100.0)
