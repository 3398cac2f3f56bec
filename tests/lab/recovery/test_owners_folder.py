"""An owner's folder: a pitot that was changed between two flights is seen, and dated."""

from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

from tests.calibration import trajectories as fixture

from pitotbench.cli.app import main
from pitotbench.logbook.formats import write_log

BEFORE, FLIGHTS = 6, 12


def write_flights(folder: Path) -> None:
    """Twelve flights of an airplane, seventeen days apart; from the seventh on its pitot loses 4 %."""
    for number in range(FLIGHTS):
        log = fixture.fly(fixture.circles(5), 5, 1, fixture.Air(), seed=100 + number)
        kept = 1.0 if number < BEFORE else 0.96
        day = datetime(2026, 5, 3, 9) + timedelta(days=17 * number)
        log = replace(
            log,
            impact_pressure=kept * log.impact_pressure,
            header={**log.header, "start": f"{day}"},
        )
        write_log(log, folder / f"{7 * number % FLIGHTS:02d}.csv")


def test_a_changed_pitot_is_dated(tmp_path, capsys):
    folder, page = tmp_path / "flights", tmp_path / "page.html"
    folder.mkdir()
    write_flights(folder)
    assert main(["calibrate", str(folder), "--separately", "--report", str(page)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    for text in (said, page.read_text(encoding="utf-8")):
        assert "between 2026-07-27 and 2026-08-13 (from 06.csv on)" in text
    assert "Correction over the dates of the flights" in page.read_text(encoding="utf-8")
