"""What a calibration can be asked.

Flags, keywords of Python, settings of the page and lines of the record are made from the fields of
these records: a new option is a new field, and nothing else.
"""

from collections.abc import Iterator
from dataclasses import Field, dataclass, field, fields
from pathlib import Path
from typing import Any, NamedTuple

from pitotbench.records import USUAL_ACCURACIES

_USUAL = ", ".join(f"{name}={value:g}" for name, value in USUAL_ACCURACIES.items())


def option(
    default: Any,
    flag: str = "",
    said: str = "",
    unit: str = "",
    usual: str = "",
    fact: bool = False,
    **settings: Any,
) -> Any:
    """Declare a field that can be asked for by its flag, with its help and unit.

    The unit is a suffix of `pitotbench.units`. In a record of texts, `usual` is what stands for
    none, and a `fact` is one of the flight that its log does not hold (`FACTS`). `settings` are
    further ones of `ArgumentParser.add_argument`.
    """
    settings["help"] = f"{said} [{unit}]" if unit else said
    if isinstance(default, bool):
        settings |= {"action": "store_const", "const": "yes"}
    told = {"flag": flag, "unit": unit, "usual": usual, "fact": fact, "settings": settings}
    return field(default=default, metadata=told)


class Unstated(str):
    """A choice that nobody stated, such as that of the published figures.

    Equal to its text, it gives way to what a mapping advises and to the defaults of who asks.
    """

    __slots__ = ()


class NamedFile(NamedTuple):
    """A file, and the name by which the user knows it."""

    path: Path
    name: str


@dataclass(frozen=True, slots=True)
class Reading:
    """How a log is read, in the texts of the flags; empty where not stated.

    The path of `mapping` is a file or a shipped name.
    """

    mapping: NamedFile | None = option(
        None,
        "--mapping",
        "how to read a foreign log: a shipped name or a TOML file (default: known formats are "
        "recognized)",
        usual="as recognized",
    )
    begin: str = option(
        "",
        "--from",
        "use the log from this minute on, such as 12:30",
        usual="the first row",
        metavar="MIN:S",
    )
    end: str = option(
        "",
        "--to",
        "use the log up to this minute, such as 25:00",
        usual="the last row",
        metavar="MIN:S",
    )
    without: tuple[str, ...] = option(
        (),
        "--without",
        "leave out the minutes between, such as 14:00-15:30; may be given several times",
        usual="none",
        metavar="MIN:S-MIN:S",
        action="append",
    )
    temperature_c: str = option(
        "",
        "--temperature-c",
        "temperature of the day [°C], lapsed with height, for a log without a probe of the air: "
        "18, 18±2@ground (the lowest height of the log), -5+-2@1500ft (default: a standard day "
        "±15 K)",
        usual="as logged, else a standard day",
        fact=True,
        metavar="T±2σ@PLACE",
    )
    height: str = option(
        "",
        "--height",
        "height above the sea that was flown, for a log that holds none: 2000 (ft), 600m, "
        "2000±300ft (default: as logged)",
        usual="as logged",
        fact=True,
        metavar="HEIGHT±2σ",
    )

    def texts(self) -> Iterator[tuple[Field[Any], list[str]]]:
        """Yield each field that can be asked for, with the texts that its flag takes to ask it."""
        for each in (f for f in fields(self) if f.metadata):
            value = getattr(self, each.name)
            if isinstance(value, NamedFile):
                value = value.name
            yield each, [*value] if isinstance(value, tuple) else [value] if value else []

    def facts(self) -> dict[str, Any]:
        """Return what is stated of the flight, by name, as `read_log` takes it."""
        return {name: text for name in FACTS if (text := getattr(self, name))}


# The fields that say what is known of a flight and is not in its log.
FACTS = tuple(each.name for each in fields(Reading) if each.metadata["fact"])


@dataclass(frozen=True, slots=True)
class CalibrationRequest(Reading):
    """What is asked in addition to the logs and to the options, in the texts of the flags."""

    limit: str = option(
        "",
        "--limit",
        "judge the curve by far25, far23, none, or your own, such as 2%%,3kt,30ft (altitude for "
        "each 100 kt) (default: far23 below Mach 0.6, else far25, where the curve reaches 60 kt)",
        usual="auto",
    )
    parameters: str = option(
        "",
        "--params",
        "also the parameters to set: ardupilot or px4, with the old values where the log has none "
        "(px4,ASPD_SCALE_1=1,SENS_DPRES_OFF=0)",
        usual="none",
        metavar="AUTOPILOT",
    )
    handbook: NamedFile | None = option(
        None,
        "--handbook",
        "compare the curve with that of a handbook: columns KIAS, KCAS and, where it has several, "
        "configuration",
        usual="none",
        metavar="TABLE.csv",
        type=Path,
    )
    airspeed_sensor: str = option(
        "",
        "--airspeed-sensor",
        "which airspeed sensor of a log with several, from 1 (default: the first)",
        usual="the first",
        metavar="N",
        type=int,
    )


@dataclass(frozen=True, slots=True)
class CalibrationChoices:
    """The options of a calibration, as `CalibrationOptions` takes them."""

    model: str = option(
        "inverse+", "--model", "pressure-error model (default: the mapping's, else smooth)"
    )
    method: str = option("covering", "--method", "covering or paper (default: covering)")
    error_location: str = option(
        "auto",
        "--error-location",
        "auto (by GPS height where the log has it), static, total or impact (as published) "
        "(default: the mapping's, else auto)",
    )
    use_down: bool = option(True, "--no-down", "do not use the vertical GPS velocity")
    use_altitude: bool = option(True, "--no-altitude", "do not use the height by GPS")
    on_condition: bool = option(False, "--on-condition", "use only rows flagged on condition")
    mach_max: float | None = option(
        None, "--mach-max", "leave out rows above this Mach number", type=float
    )
    ground_speed_min: float = option(
        0.0, "--ground-speed-min-kt", "leave out rows below this ground speed", "kt", type=float
    )
    slowest: float | None = option(
        None,
        "--slowest",
        "leave out rows below this indicated airspeed, such as 8 for a solar drone (default: 20)",
        "kt",
        type=float,
    )
    wind_down: bool = False
    recovery_factor: float = 1.0
    wind: str = option(
        Unstated("constant"),
        "--wind",
        "constant, checked (constant or changing, averaged by evidence; drifting in a long "
        "flight), linear (in time and height) or drifting (default: checked); or what it was: 0, "
        "8@250 (kt from °, 2 kt where no ± stands), 8±1@250",
    )
    gps_latency: float = option(0.0, unit="s")
    latency: str = option(
        Unstated("given"),
        "--latency",
        "seconds by which GPS velocity trails the air data, or `estimated` from the log, or "
        "`checked` (default)",
    )
    robust: bool = option(True, "--all-rows", "keep faulty rows")
    accuracies: Any = option(
        None,
        "--accuracy",
        "2σ of constant errors, such as temperature_k=1,static_pressure_pa=40; `none`: sensors "
        f"without constant errors (default: what the mapping or the log states, else {_USUAL})",
        metavar="NAME=2σ,...",
    )
    priors: Any = option(
        None,
        "--set",
        "a prior other than the usual one, such as gust_length_m=300 (docs/method.md lists them)",
        metavar="NAME=NUMBER,...",
    )


FILES = ("mapping", "handbook")  # the fields of a request that are files


def asked_fields(*records: type) -> list[Field[Any]]:
    """Return the fields of records that have a flag."""
    return [each for record in records for each in fields(record) if each.metadata.get("flag")]
