"""The pages for users whose commands fly and judge for long run from top to bottom."""

import pytest
from tests.test_pages_run import LONG, PAGES, run_page


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.long] * (n == "reconcile")) for n in LONG]
)
def test_a_long_page_runs_from_top_to_bottom(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (page,) = (page for page in PAGES if page.stem == name)
    run_page(page, tmp_path)
