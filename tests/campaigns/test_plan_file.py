"""The plan of a campaign: what a file varies, lazily, with names and keys by content."""

from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from pitotbench import BadInputError, CampaignRequest, UnknownNameError
from pitotbench.campaigns.costs import forecast_of_costs
from pitotbench.campaigns.draws import Draws
from pitotbench.campaigns.plan_file import read_plan, seeds_of
from pitotbench.campaigns.task import sharded
from pitotbench.cli.app import main
from pitotbench.units import FOOT, KNOT

PLAN = """
das = ["20/1", "50/50"]
seeds = "501-503"

[case]
altitude_ft = 4000
effects = [{ name = "gps_latency", parameters = { latency_s = 0.3 } }]

[grid]
maneuver = ["circle", "rapid_decel"]
"wind.speed_kt" = [0, 15, 30]
"effects.0.parameters.latency_s" = [0.1, 0.5]

[[list]]
turbulence = "none"
[[list]]
turbulence = "light"
[list.pressure_error]
location = "static"

[[calibrate]]
model = ["inverse+", "bias"]
[[calibrate]]
label = "paper"
method = "paper"
"""

DRAWN = """
[case]
maneuver = "circle"
[draw]
count = 8
method = "{}"
"wind.speed_kt" = {{ low = 0, high = 40 }}
"das.impact_pressure_noise_pa" = {{ low = 1, high = 100, log = true }}
temperature_offset_k = {{ mean = 0, sd = 5 }}
turbulence = {{ choose = ["none", "light"] }}
"""


def plan_of(folder, text):
    path = folder / "plan.toml"
    path.write_text(text)
    return read_plan(path)


def test_a_plan_is_rows_times_grid_times_seeds(tmp_path):
    plan = plan_of(tmp_path, PLAN)
    tasks = list(plan.tasks())
    assert plan.count == len(tasks) == 2 * 2 * 3 * 2 * 3
    assert len({task.key for task in tasks}) == len({task.name for task in tasks}) == len(tasks)
    latency = "effects.0.parameters.latency_s"
    assert plan.varied == ("turbulence", "pressure_error.location", "wind.speed_kt", latency)
    assert {task.case.altitude for task in tasks} == {4000.0 * FOOT}
    assert {task.case.wind.speed for task in tasks} == {0.0, 15.0 * KNOT, 30.0 * KNOT}
    assert {task.case.effects[0].parameters["latency_s"] for task in tasks} == {0.1, 0.5}
    rows = {(task.case.turbulence, task.case.pressure_error.location) for task in tasks}
    assert rows == {("none", "impact"), ("light", "static")}
    assert {task.case.truth_seed for task in tasks} == {501, 502, 503}
    ways = [(label, options.model, options.method) for label, options in tasks[0].calibrations]
    assert ways == [
        ("", "inverse+", "covering"),
        ("", "bias", "covering"),
        ("paper", "inverse+", "paper"),
    ]
    assert [system.label for system in tasks[0].systems] == ["20/1", "50/50"]


@pytest.mark.parametrize("method", ["random", "latin_hypercube"])
def test_draws_are_inside_their_spread_repeatable_and_have_seeds_of_their_own(tmp_path, method):
    plan = plan_of(tmp_path, DRAWN.format(method))
    tasks = list(plan.tasks())
    assert len(tasks) == plan.count == 8
    assert [task.key for task in tasks] == [task.key for task in plan.tasks()]
    assert [task.case.truth_seed for task in tasks] == list(range(1, 9))
    speeds = np.array([task.case.wind.speed for task in tasks]) / KNOT
    assert np.all((speeds >= 0.0) & (speeds <= 40.0))
    assert {task.systems[0] for task in tasks} == {
        task.case.das for task in tasks
    }  # with its own noise
    if method == "latin_hypercube":  # one draw in each eighth
        assert sorted(np.floor(speeds / 5.0)) == list(range(8))
        noise = [np.log10(task.case.das.impact_pressure_noise) for task in tasks]
        assert sorted(np.floor(np.array(noise) * 4.0)) == list(range(8))


def test_quantiles_of_a_normal_and_of_whole_numbers():
    draws = Draws(
        {"a": {"mean": 3.0, "sd": 2.0}, "b": {"low": 1, "high": 3, "whole": True}}, count=4000
    )
    values = list(draws.values())
    assert np.mean([v["a"] for v in values]) == pytest.approx(3.0, abs=0.15)
    assert np.std([v["a"] for v in values]) == pytest.approx(2.0, abs=0.15)
    assert {v["b"] for v in values} == {1, 2, 3}
    longer = Draws(draws.fields, count=5000)
    assert list(islice(longer.values(), 10)) == values[:10]


def test_shards_share_a_plan_out_and_keys_do_not_depend_on_them(tmp_path):
    plan = plan_of(tmp_path, PLAN)
    parts = [list(sharded(plan.tasks(), (part, 5))) for part in range(1, 6)]
    keys = [task.key for part in parts for task in part]
    assert sorted(keys) == sorted(task.key for task in plan.tasks())
    assert max(map(len, parts)) - min(map(len, parts)) <= 1


def test_the_key_is_that_of_the_content():
    from pitotbench.calibration.options import CalibrationOptions
    from pitotbench.campaigns.task import cell_digest, content_key
    from pitotbench.records.case import Case, DataSystem, Wind

    ways = (("", CalibrationOptions()),)
    case, system = Case(), DataSystem()
    key = content_key(cell_digest(case, [system], ways), case)
    others = [
        (replace(case, wind=Wind(up=0.1)), system, ways),
        (case, replace(system, velocity_noise=0.06), ways),
        (case, system, (("", CalibrationOptions(robust=False)),)),
    ]
    keys = {content_key(cell_digest(c, [s], w), c) for c, s, w in others}
    assert (
        len(
            keys
            | {key, content_key(cell_digest(case, [system], ways), replace(case, sensor_seed=2))}
        )
        == 5
    )


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("seed = 3", "seeds"),
        ('[grid]\n"wind.sped_kt" = [1]', "speed_kt"),
        ('[grid]\n"wind.speed_kt" = [1, "two"]', "speed_kt"),
        ("[grid.wind]\nspeed_kt = [1]", "in quotes"),
        ("[grid]\nturbulence = []", "list of values"),
        ("[draw]\nfuel = { low = 0.5, high = 1 }", "count"),
        ("[draw]\ncount = 3\nfuel = { low = 1, high = 0.5 }", "low <= high"),
        ("[draw]\ncount = 3\nfuel = { least = 1 }", "low, high"),
        ('[draw]\ncount = 3\nmethod = "sobol"\nfuel = { low = 0.5, high = 1 }', "latin_hypercube"),
        ('[case]\naltitude = 3', "altitude_ft"),
        ('das = ["20/1"]\n[grid]\n"das.gps_latency_s" = [0, 1]', "not both"),
        ('[[calibrate]]\n[[calibrate]]\nmethod = "paper"', "label"),
        ('[case]\ncard = { dwell_m = 3 }', "dwell"),
        ('[grid]\n"effects.0.name" = ["a"]', "effects"),
        ('seeds = "9-3"', "not above"),
        ("[case", "not valid TOML"),
    ],
)  # fmt: skip
def test_a_wrong_plan_is_refused_by_name_before_anything_is_flown(tmp_path, text, says):
    with pytest.raises((BadInputError, UnknownNameError), match=r"(?s)" + says):
        plan_of(tmp_path, text)


def test_seeds_are_a_number_or_a_range():
    assert list(seeds_of("3")) == [1, 2, 3]
    assert list(seeds_of("501-503")) == [501, 502, 503]
    for wrong in ("0", "x", "5-", "3-1"):
        with pytest.raises(BadInputError, match="seeds"):
            seeds_of(wrong)


def test_a_dry_run_prints_counts_minutes_and_bytes_and_makes_nothing(tmp_path, capsys):
    plan_of(tmp_path, PLAN)
    out = tmp_path / "out"
    flags = ["--dry-run", "--shard", "1/2", "--jobs", "4"]
    assert main(["campaign", str(tmp_path / "plan.toml"), "--out", str(out), *flags]) == 0
    said = capsys.readouterr().out
    assert "flights: 36 (3 calibrations each; varied: turbulence, " in said
    assert "on 4 processes" in said
    assert "GB" in said
    assert not out.exists()
    twice = forecast_of_costs(CampaignRequest(plan=tmp_path / "plan.toml", out=out))
    assert "flights: 72" in next(twice)


def test_the_plan_of_the_page_on_scale_is_one(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "scale.md").read_text(encoding="utf-8")
    text = page.partition("## The plan")[2].partition("```toml\n")[2].partition("```")[0]
    plan = plan_of(tmp_path, text)
    assert plan.count == 2 * 2 * 3 * 200 * 30
    assert [label for label, _ in plan.calibrations] == ["", "", "paper"]
    cases = [task.case for task in islice(plan.tasks(), 0, 6001, 30)]
    assert {case.wind.speed for case in cases} == {0.0, 15.0 * KNOT}
    assert len({case.das.static_pressure_noise for case in cases}) == 200


RANDOM = '[draw]\nmethod = "{method}"\ncount = {count}\nseed = {seed}\nfuel = {fuel}'
DRAW = {"method": "random", "count": "2", "seed": "1", "fuel": "{low = 0.5, high = 1.0}"}
WRONG_TYPES = {
    'calibrate = "bias"': "calibrate: give a table",
    "calibrate = [true]": "calibrate: give a table",
    "calibrate = 3": "calibrate: give a table",
    "calibrate = [{ model = 3 }]": "model is a name or a list of names",
    'calibrate = [{ model = [["bias"]] }]': "model is a name or a list of names",
    'calibrate = { use_down = "no" }': "use_down: give true or false",
    'calibrate = { mach_max = "0.4" }': "mach_max: give a number",
    "calibrate = { wind = 3 }": "wind: give a text",
    "calibrate = { robust = 1 }": "robust: give true or false",
    "seeds = 1" + 400 * "0": "too large for a plan",
    "[case]\ncard = 3": "card: input should be a table",
} | {
    RANDOM.format(**{**DRAW, **change}): says
    for change, says in (
        ({"seed": "1.5"}, "count and seed are whole numbers"),
        ({"seed": "-1"}, "count and seed are whole numbers"),
        ({"seed": "1.5", "method": "latin_hypercube"}, "count and seed are whole numbers"),
        ({"count": "true"}, "count and seed are whole numbers"),
        ({"count": "1" + 400 * "0"}, "too many flights"),
        ({"fuel": "{low = 0.5, high = 1" + 400 * "0" + "}"}, "is no spread"),
    )
}


@pytest.mark.parametrize("text", WRONG_TYPES, ids=lambda text: text[:40])
def test_a_value_of_a_wrong_type_is_refused_in_one_line(text, tmp_path, capsys):
    (tmp_path / "plan.toml").write_text(text)
    assert main(["campaign", str(tmp_path / "plan.toml"), "--dry-run"]) == 2
    said = capsys.readouterr().err
    assert WRONG_TYPES[text] in said
    assert "Error" not in said


def test_a_method_that_is_no_text_is_refused(tmp_path):
    for method in (3, [[1]]):
        with pytest.raises(BadInputError, match="unknown method of draws"):
            plan_of(
                tmp_path, f"[draw]\nmethod = {method}\ncount = 2\nfuel = {{low = 0.5, high = 1.0}}"
            )


def test_whole_numbers_are_good_options(tmp_path):
    plan = plan_of(tmp_path, "[calibrate]\nrecovery_factor = 1\nmach_max = 1\nrobust = false")
    assert plan.calibrations[0][1].mach_max == 1


def test_the_systems_of_the_plan_decide_which_rates_fit(tmp_path):
    rate = "[case]\nintegration_rate_hz = 40\n"
    (case,) = plan_of(tmp_path, f'das = ["20/1"]\n{rate}').cells()
    assert case.integration_rate == 40.0
    (task,) = plan_of(tmp_path, f'das = ["20/1"]\n{rate}[case.das]\nair_rate_hz = 50\n').tasks()
    assert [system.label for system in task.systems] == ["20/1"]
    for text in (f'das = ["20/1", "50/50"]\n{rate}', rate):
        with pytest.raises(BadInputError, match="not a whole multiple of the 50 Hz"):
            plan_of(tmp_path, text)
