"""A table of Mode S repeats each airspeed until the next answer, up to half a minute later."""

import numpy as np
import pytest

from pitotbench import air, calibrate, read_log
from pitotbench.units import FOOT, KNOT

CORRECTION = 3.0  # kt
HEIGHT = 20_000.0  # ft


def table(path, seed):
    """Decelerations in turns on a standard day, with IAS answered at random moments; out of reach of
    the receiver between them.
    """
    rng = np.random.default_rng(seed)
    time = np.concatenate([200.0 * leg + np.arange(110.0) for leg in range(12)])
    kias = 300.0 - 0.8 * (time % 200.0)
    pressure = air.standard_pressure(np.full(len(time), HEIGHT * FOOT))
    mach = air.mach_from_impact_pressure(air.impact_pressure((kias + CORRECTION) * KNOT), pressure)
    true = mach * np.sqrt(
        1.4 * 287.053 * air.standard_temperature(np.full(len(time), HEIGHT * FOOT))
    )
    heading = np.radians(rng.uniform(0, 360) + time * rng.choice([-1.0, 1.0]) * 0.7)
    wind = rng.normal(0.0, 12.0, 2)
    gust = rng.normal(0.0, 0.15, (2, len(time)))
    north, east = (
        true * np.cos(heading) + wind[0] + gust[0],
        true * np.sin(heading) + wind[1] + gust[1],
    )
    answers = np.concatenate(
        [200.0 * leg + np.append(0.0, np.cumsum(rng.uniform(10.0, 30.0, 11))) for leg in range(12)]
    )
    answers = answers[answers % 200.0 < 110.0].astype(int)
    last = np.searchsorted(time, answers[np.searchsorted(answers, time, side="right") - 1])
    shown = np.round(kias + rng.normal(0.0, 0.7, len(time)))[last]
    rows = [
        f"{t:.0f},3c0000,T1,{HEIGHT:.0f},{v:.0f},{np.hypot(n, e) / KNOT:.0f},"
        f"{np.degrees(np.arctan2(e, n)) % 360:.2f}"
        for t, v, n, e in zip(time, shown, north, east, strict=True)
    ]
    path.write_text("\n".join(["timestamp,icao24,callsign,altitude,IAS,groundspeed,track", *rows]))
    return path


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_row_counts_where_its_airspeed_is_new(tmp_path, seed):
    log = read_log(table(tmp_path / "table.csv", seed))
    assert 20 < len(log) < 200
    assert np.all(np.diff(log.impact_pressure) != 0.0)
    assert "repeats each value until the next answer" in " ".join(log.cautions)
    curve = calibrate(log).curve
    assert np.all(np.abs(curve.correction_kt - CORRECTION) <= curve.two_sigma_kt)
    # A value that is 10 s old is 8 kt high here; a standard day alone leaves the bound at 7 kt.
    assert np.all(np.abs(curve.correction_kt - CORRECTION) < 2.0)
