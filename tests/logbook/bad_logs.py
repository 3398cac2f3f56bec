"""Bad logs as one table: how each is made, and what the refusal of it says; with the good logs they
are made of.
"""

import gzip
import os
import re
from collections.abc import Callable
from functools import partial, reduce
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from numpy.typing import NDArray
from pyarrow import parquet
from scipy.io import savemat
from tests.logbook import sample_log as sample

from pitotbench import air, write_log
from pitotbench.logbook.formats import FORMATS
from pitotbench.units import KNOT

Table = dict[str, NDArray]
TIME = np.arange(sample.ROWS) / sample.RATE


def put(name: str, rows: slice | int, value: float) -> Callable[[Table], Table]:
    """Spoil some rows of a column."""

    def spoil(table: Table) -> Table:
        values = table[name].astype(object if isinstance(value, str) else float)
        values[rows] = value
        return {**table, name: values}

    return spoil


def change(name: str, function: Callable[[NDArray], NDArray]) -> Callable[[Table], Table]:
    return lambda table: {**table, name: function(table[name])}


def scale(name: str, factor: float) -> Callable[[Table], Table]:
    return change(name, lambda values: values * factor)


def drop(*names: str) -> Callable[[Table], Table]:
    return lambda table: {k: v for k, v in table.items() if k not in names}


def rename(old: str, new: str) -> Callable[[Table], Table]:
    return lambda table: {new if k == old else k: v for k, v in table.items()}


def add(name: str, like: str) -> Callable[[Table], Table]:
    return lambda table: {**table, name: table[like]}


def first(rows: int) -> Callable[[Table], Table]:
    return lambda table: {name: values[:rows] for name, values in table.items()}


def then(*spoils: Callable[[Table], Table]) -> Callable[[Table], Table]:
    """One after the other."""
    return lambda table: reduce(lambda spoiled, spoil: spoil(spoiled), spoils, table)


def of(table: Table, *spoils: Callable[[Table], Table]) -> Callable[[Table], Table]:
    """Another log in place of the sample, spoiled."""
    return lambda _: then(*spoils)(table)


def faster(factor: float) -> Callable[[Table], Table]:
    return then(scale("velocity_north_mps", factor), scale("velocity_east_mps", factor))


def stepping(column: str, step: float) -> Callable[[Table], Table]:
    """Another clock in the first column."""
    clock = {column: np.arange(sample.ROWS) * step}
    return lambda table: clock | drop("time_s")(table)


def flown(heading, speed=65.0, wind=(5.0, -6.0), height=1830.0, temperature=276.3):
    """The sample log with other headings [rad], airspeed [m/s], wind toward north and east [m/s],
    height [m].
    """
    rng = np.random.default_rng(7)
    table = sample.columns()
    speed = speed * (1.0 + 0.1 * np.sin(TIME / 20.0)) + 0.2 * rng.standard_normal(sample.ROWS)
    mach = speed / air.sound_speed(temperature)
    static = air.standard_pressure(height) + 3.0 * rng.standard_normal(sample.ROWS)
    probe = air.total_temperature(temperature, mach) + 0.1 * rng.standard_normal(sample.ROWS)
    return table | {
        "impact_pressure_pa": air.impact_pressure_from_mach(mach, static),
        "static_pressure_pa": static,
        "total_temperature_k": probe,
        "altitude_m": height + rng.standard_normal(sample.ROWS),
        "heading_rad": heading % (2.0 * np.pi),
        "velocity_north_mps": speed * np.cos(heading)
        + wind[0]
        + 0.05 * rng.standard_normal(sample.ROWS),
        "velocity_east_mps": speed * np.sin(heading)
        + wind[1]
        + 0.05 * rng.standard_normal(sample.ROWS),
    }


CIRCLE, SOUTH = TIME / 9.0, np.full(sample.ROWS, np.pi)
OUT_AND_BACK = np.where(TIME < 30.0, 0.6, 0.6 + np.pi)

GOOD = {
    "a circle": flown(CIRCLE),
    "a circle in 60 kt of wind": flown(CIRCLE, wind=(-60.0 * KNOT, 0.0)),
    "one heading with 40 kt of tail wind": flown(SOUTH, wind=(-40.0 * KNOT, 0.0)),
    "out and back": flown(OUT_AND_BACK, wind=(12.0, 3.0)),
    "a jet in a jet stream": flown(CIRCLE / 4.0, 220.0, (45.0, 50.0), 9000.0, 230.0),
    "a small airplane in a wind of half its speed": flown(CIRCLE, 14.0, (7.0, 0.0), 100.0, 285.0),
    "a day 25 K above standard": flown(CIRCLE, temperature=301.0),
    "a day 25 K below standard": flown(CIRCLE, temperature=251.0),
}
NEEDED = (
    "time_s",
    "impact_pressure_pa",
    "static_pressure_pa",
    "velocity_north_mps",
    "velocity_east_mps",
)


def with_decimal_commas(mark):
    table = sample.columns()
    del table["segment"], table["on_condition"]
    rows = [
        mark.join(str(value).replace(".", ",") for value in row)
        for row in zip(*table.values(), strict=True)
    ]
    return table, [mark.join(table), *rows]


NAN = float("nan")
PITOT, STATIC, PROBE = "impact_pressure_pa", "static_pressure_pa", "total_temperature_k"
CLOCK, NORTH, EAST = "time_s", "velocity_north_mps", "velocity_east_mps"
KNOTS = "look like knots: name the columns velocity_north_kt and velocity_east_kt"

# What is wrong with the columns, and what is said of it.
_SPOILED: dict[str, tuple[Callable[[Table], Table], str]] = {
    "no time": (drop(CLOCK), r"missing column time_s"),
    "time runs back": (
        put(CLOCK, 300, 2.0),
        r"'time_s', row 301: time runs back from 29.9 to 2 s.*sort the rows",
    ),
    "time stands still": (
        change(CLOCK, lambda t: np.minimum(t, 30.0)),
        r"time stamps repeat.*more digits",
    ),
    "NaN in most rows": (
        put(PITOT, slice(100, 450), NAN),
        r"350 of 600 values are not numbers \(rows 101–450\): too few rows remain",
    ),
    "time NaN often": (put(CLOCK, slice(100, 150), NAN), r"'time_s': 50 of 600"),
    "text in a number": (
        put(STATIC, 41, "err"),
        r"'static_pressure_pa', row 42: 'err' is not a number",
    ),
    "no flag": (
        put("on_condition", 6, "perhaps"),
        r"'on_condition', row 7: 'perhaps' is not true or false",
    ),
    "no static pressure": (drop(STATIC), r"missing column static_pressure_pa"),
    "much missing": (
        drop(NORTH, EAST, PITOT),
        r"missing columns velocity_north_mps or ground_speed_kt with track_deg or latitude_deg "
        r"with longitude_deg, "
        r"velocity_east_mps, impact_.*--mapping",
    ),
    "misspelled": (
        rename(PITOT, "impact_presure_pa"),
        r"Is 'impact_presure_pa' meant for impact_pressure_pa",
    ),
    "unknown suffix": (
        rename("altitude_m", "altitude_furlong"),
        r"unknown unit suffix 'furlong'.*altitude_m",
    ),
    "wrong dimension": (
        rename("altitude_m", "altitude_kt"),
        r"'kt' is a unit of speed, but altitude is of length",
    ),
    "two units of one": (
        add("altitude_ft", "altitude_m"),
        r"'altitude_m' and 'altitude_ft' give one quantity in two",
    ),
    "column twice": (add("altitude_m ", "altitude_m"), r"'altitude_m' is given twice"),
    "inches said to be pascal": (
        scale(STATIC, 1 / 3386.389),
        r"typical values of 23\.98 pa are not those of an airplane; they would fit "
        r".*static_pressure_inhg",
    ),
    "Celsius said to be kelvin": (
        change(PROBE, lambda t: t - 273.15),
        r"typical values of 5\.\d+ k.*total_temperature_degc",
    ),
    "knots of feet": (scale(NORTH, 100.0), r"velocity_north_mps.*not those of an airplane"),
    "millibar said to be pascal": (
        scale(PITOT, 0.01),
        r"air data say about 7 m/s.*name the column impact_pressure_hpa",
    ),
    "feet per second said to be meters": (
        faster(3.28084),
        r"the air data say about.*name the columns velocity_north_fps and velocity_east_fps",
    ),
    "Fahrenheit said to be kelvin": (
        change(PROBE, lambda t: t * 1.8 - 459.67),
        r"they would fit total_temperature_degf",
    ),
    "negative impact pressure": (scale(PITOT, -1.0), r"negative in 600 of 600 rows.*swap them"),
    "stuck pitot": (scale(PITOT, 0.0), r"stuck at 0 Pa in every row"),
    "mostly stuck pitot": (put(PITOT, slice(100, 580), 2500.0), r"rows 101–580.*80 % of the log"),
    "stuck GPS": (
        then(put(NORTH, slice(None), 60.0), put(EAST, slice(None), 1.0)),
        r"GPS velocity is the same in every row",
    ),
    "nothing remains": (
        then(first(3), put(STATIC, 0, NAN), put(PITOT, 1, NAN)),
        r"1 of 2 values are not numbers .*no log remains",
    ),
    "one row": (first(1), r"at least 2 are needed"),
    "no rows": (first(0), r"no rows"),
    "knots on the headings of a jet in a jet stream": (
        of(GOOD["a jet in a jet stream"], faster(1.0 / KNOT)),
        KNOTS,
    ),
    "no day is so warm": (
        of(flown(CIRCLE, height=8000.0, temperature=236.2 + 70.0)),
        "70 K warmer than on a standard day",
    ),
    **{
        f"{column} in steps of {step:g}": (stepping(column, step), says)
        for column, step, says in (
            (CLOCK, 50.0, r"rows are 50 s apart.*50 between rows would fit a column named time_ms"),
            ("time_ms", 0.05, r"0\.05 between rows would fit a column named time_s"),
            (CLOCK, 1e6, r"check the unit of the clock"),
            (CLOCK, 100.0, r"time_ms"),
            (CLOCK, 1e-10, r"unit of the clock"),
        )
    },
    "a height that does not say its unit": (
        rename("altitude_m", "altitude_"),
        r"'altitude_' does not say its unit; name it altitude_m, altitude_ft",
    ),
    "a pressure of the weather report": (
        put(STATIC, slice(None), 101325.0),
        r"looks reduced to sea level \(QNH\) or constant: record the pressure at the airplane",
    ),
    "a pressure of no place": (
        scale(STATIC, 1.8),
        r"typical values of 1\.462e\+05 pa are not those of an airplane: check its scale",
    ),
    "total pressure in place of the static one": (
        lambda table: {**table, STATIC: table[STATIC] + table[PITOT]},
        r"looks like total pressure; name the column total_pressure_pa and give the static",
    ),
}


def _spoiled(spoil: Callable[[Table], Table], folder: Path) -> Path:
    return sample.write(folder / "flight7.csv", spoil(sample.columns()))


def _edited(edit: Callable[[list[str]], list[str]], folder: Path) -> Path:
    """The sample log as a CSV file whose lines are changed."""
    path = sample.write(folder / "flight7.csv", sample.columns())
    path.write_text("\n".join(edit(path.read_text().splitlines())))
    return path


def _file(name: str, content: bytes, folder: Path) -> Path:
    (folder / name).write_bytes(content)
    return folder / name


def _cut(suffix: str, share: float, folder: Path) -> Path:
    whole = write_log(sample.log(), folder / f"whole{suffix}").read_bytes()
    return _file(f"cut{suffix}", whole[: int(share * len(whole))], folder)


def _mixed_marks(mark: str, folder: Path) -> Path:
    head, row, *rest = with_decimal_commas(mark)[1]
    return _file("flight7.csv", "\n".join([head, row.replace(",", "."), *rest]).encode(), folder)


def _unequal(folder: Path) -> Path:
    table = {name: values for name, values in sample.columns().items() if name != "segment"}
    savemat(folder / "log.mat", {**table, "time_s": TIME[:5]})
    return folder / "log.mat"


def _solid(folder: Path) -> Path:
    savemat(folder / "log.mat", {"time_s": TIME, PITOT: np.ones((2, 3, 4))})
    return folder / "log.mat"


def _text_of_bytes(folder: Path) -> Path:
    """A Parquet file with one flipped byte in a text."""
    path = folder / "flight7.parquet"
    table = {
        **{name: sample.columns()[name] for name in NEEDED},
        "segment": ["leg two"] * sample.ROWS,
    }
    parquet.write_table(pa.table(table), path, compression="none", use_dictionary=False)
    path.write_bytes(path.read_bytes().replace(b"leg two", b"leg\xfftwo", 3))
    return path


_BOMB = 60_000_000  # numbers, in files of a few kilobytes


def _bomb(kind: str, folder: Path) -> Path:
    path = folder / f"bomb{'.parquet' if kind == '.parquet' else '.mat'}"
    if kind == ".parquet":
        parquet.write_table(pa.table({"time_s": pa.nulls(_BOMB, pa.float64())}), path)
    elif kind == ".mat":
        savemat(path, {"flight": {"time_s": np.zeros(_BOMB, np.uint8)}}, do_compression=True)
    else:
        h5py = pytest.importorskip("h5py", reason="needs the extra pitotbench[hdf5]")
        with h5py.File(path, "w") as file:
            file.create_dataset("time_s", shape=(_BOMB,), chunks=(1000,), dtype="f8")
    return path


def _many_groups(folder: Path) -> Path:
    """A Parquet file of 117 kB whose table of contents lists one group of rows 1,024 times: 98 GB."""
    one, path = folder / "one.parquet", folder / "bomb.parquet"
    parquet.write_table(pa.table({"time_s": pa.nulls(12_000_000, pa.float64())}), one)
    listed = parquet.read_metadata(one)
    for _ in range(10):
        listed.append_row_groups(listed)
    listed.write_metadata_file(path)
    data, contents = one.read_bytes(), path.read_bytes()
    place = len(data) - 8 - int.from_bytes(data[-8:-4], "little")
    path.write_bytes(data[:place] + contents[4:])
    return path


def repeated_text(folder: Path, rows: int, name: str) -> Path:
    """A Parquet file with one long text in each row, which it holds once."""
    path = folder / "bomb.parquet"
    text = pa.DictionaryArray.from_arrays(np.zeros(rows, np.int32), ["x" * 20_000])
    table = {channel: sample.columns()[channel] for channel in NEEDED}
    tiled = {channel: np.resize(values, rows) for channel, values in table.items()}
    if name == "segment":
        tiled["time_s"] = np.arange(rows) / sample.RATE
    parquet.write_table(pa.table({**tiled, name: text}), path)
    return path


def _pipe(suffix: str, folder: Path) -> Path:
    os.mkfifo(folder / f"pipe{suffix}")
    return folder / f"pipe{suffix}"


_CSV = {  # what is wrong with a CSV file: its bytes, and what is said
    "decimal commas between commas": (
        b"time_s,static_pressure_pa\n0,1,81200,5\n0,2,81200,5\n",
        r"row 1 has 4 columns, the first line names 2 \(decimal commas\?",
    ),
    "half of a letter of UTF-16": (
        b"\xff\xfea\x00,",
        "not complete UTF-16 text: save the log as UTF-8",
    ),
    "a lone carriage return": (b"a,b\n1\r2,3\n", r"row 1 has 1 columns, the first line names 2"),
    "a very long cell": (
        b"# " + b"x" * 140_000 + b"\na,b\n" + b"9" * 140_000 + b",1\n",
        "a table without a time",
    ),
    "a short row that is not UTF-8": (b"time_s,a\n1,2\n\xff\n", "line 3 is not UTF-8 text"),
    "a megabyte of blank lines": (b"\n" * 1_100_000, "comments or blank lines"),
    "a key of thousands of parts": (
        b"# " + b".".join([b"a"] * 30_000) + b" = 1\ntime_s\n1\n",
        "missing columns",
    ),
    "far too many columns": ((",".join(["a"] * 20_000) + "\n").encode() * 2, "20,000 columns"),
    "too many columns for a draft": (
        (",".join(f"a{i}" for i in range(1001)) + "\n" + "1," * 1000 + "1\n").encode(),
        "missing columns",
    ),
}
_BINARY = {
    "flight.ulg": (b"", b"ULog", b"not a ulog at all, but long enough to have a header"),
    "flight.BIN": (b"", b"\xa3\x95", b"no log at all", b"\xa3\x95\x80" + bytes(300)),
}
_PACKED = gzip.compress(b"time_s,impact_pressure_pa\n" + b"1.0,2000\n" * 5000)
_FIX = b"B1200004600000N00700000E%c0150001500\r\n"
# What is wrong with a file of another kind: its name, its bytes, and what is said.
_FILES = {
    "a cut gzip file": ("log.csv.gz", _PACKED[:-40], "not a complete gzip file.*copy it again"),
    "no card of a display": (
        "card.zip",
        b"PK\x03\x04 and no more",
        "not a complete .zip file.*unpack",
    ),
    "no fix": ("log.igc", b"AXXX\r\nHFDTE010124\r\n", "not an IGC file.*load it .* again"),
    "no fix of three dimensions": (
        "log.igc",
        _FIX % b"V" * 9,
        ".*no fix of three dimensions .*use another log",
    ),
}
_NOTHING = (b"", b"\n\n", b"# only = 'a header'\n", b"\x00\x01\x02\xff" * 50)

# The name of a bad log: how it is made in a folder, and what the refusal says, whose exit code is
# 2.
BAD_LOGS: dict[str, tuple[Callable[[Path], Path], str]] = {
    **{
        name: (partial(_spoiled, spoil), rf"flight7\.csv: .*{says}")
        for name, (spoil, says) in _SPOILED.items()
    },
    **{name: (partial(_file, "log.csv", content), says) for name, (content, says) in _CSV.items()},
    **{
        name: (partial(_file, file, content), rf"{re.escape(file)}: {says}")
        for name, (file, content, says) in _FILES.items()
    },
    "a variable of three dimensions": (
        _solid,
        r"variable 'impact_pressure_pa' has shape \(2, 3, 4\).*save it as one, or leave it out",
    ),
    "a folder without a log": (lambda folder: folder, "a folder of no logs; name one"),
    "a ragged row": (
        partial(_edited, lambda lines: [*lines[:51], "1,2,3", *lines[52:]]),
        "row 51 has 3 columns, the first line names 14",
    ),
    "several rows that break off are no cut file": (
        partial(_edited, lambda lines: [*lines[:-2], *(line[:20] for line in lines[-2:])]),
        f"row {sample.ROWS - 1} has . columns, the first line names 14; corr",
    ),
    **{
        f"two decimal marks beside {mark!r}": (
            partial(_mixed_marks, mark),
            "has a decimal comma; write decimal points in the whole file",
        )
        for mark in (";", "\t")
    },
    **{
        f"{share:.0%} of a {suffix} file": (
            partial(_cut, suffix, share),
            rf"cut{suffix}: .*(empty|not a complete)",
        )
        for suffix in FORMATS
        for share in (0.0, 0.3, 0.9)
        if suffix != ".csv" or share == 0.0
    },
    **{
        f"{content[:20]!r} in a {suffix} file": (
            partial(_file, f"log{suffix}", content),
            r"log\.(csv|parquet|mat): ",
        )
        for suffix in FORMATS
        for content in _NOTHING
    },
    "text in Parquet that is not UTF-8": (
        _text_of_bytes,
        r"flight7\.parquet: not a complete Parquet file",
    ),
    **{
        f"a bomb of {kind}": (partial(_bomb, kind), r"would unpack to 60,000,\d+ ")
        for kind in (".parquet", ".mat", "HDF5")
    },
    "a bomb of many groups": (
        _many_groups,
        r"12,\d+,000,000 numbers, where [\d,]+ are the most",
    ),
    "a text that is no label": (
        partial(repeated_text, rows=1000, name="segment"),
        "'segment' holds a text of 20,000 letters, where 1,000 are the most",
    ),
    **{
        f"a pipe named {end}": (partial(_pipe, end), "not a regular file")
        for end in (".csv", ".mat", ".ulg", ".bin")
    },
    "no file": (lambda folder: folder / "none.csv", "cannot be read"),
    "no ending of a log": (lambda folder: folder / "x.doc", "ends in"),
    **{
        f"{content[:8]!r} as {name}": (partial(_file, name, content), rf"{name}: |needs py")
        for name, contents in _BINARY.items()
        for content in contents
    },
    "unequal lengths": (_unequal, r"differ in length .*time_s 5"),
}
