"""The table of channels against those who read it."""

from dataclasses import fields
from typing import get_args

import pytest

from pitotbench.channels import CHANNELS, Channel, Source, numbers_from
from pitotbench.records.aircraft import Motion, Reaction
from pitotbench.records.case import DataSystem
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import PLAIN
from pitotbench.simulation.properties import PROPERTIES
from pitotbench.units import SUFFIXES

MODEL_ONLY = {"mach", "temperature_offset", "roll_acceleration", "pitch_acceleration", "yaw_acceleration"}
every_channel = pytest.mark.parametrize("channel", CHANNELS.values(), ids=lambda c: c.name)


@every_channel
def test_a_line_names_a_known_source_unit_and_sensor(channel: Channel) -> None:
    assert channel.source in get_args(Source)
    assert channel.unit == "" or channel.unit in SUFFIXES
    named = {value for value in (channel.noise, channel.resolution) if isinstance(value, str)}
    assert named <= set(DataSystem.__dataclass_fields__)


def test_a_log_holds_the_channels_of_the_table_and_a_header() -> None:
    assert [f.name for f in fields(FlightLog)] == [*CHANNELS, "header"]


@pytest.mark.parametrize("channel", PLAIN, ids=lambda c: c.name)
def test_the_simulator_serves_every_channel_with_a_simulated_sensor(channel: Channel) -> None:
    assert channel.name in PROPERTIES


@pytest.mark.parametrize("record", [Motion, Reaction])
def test_motion_and_reaction_speak_of_channels(record: type) -> None:
    assert {f.name for f in fields(record)} - MODEL_ONLY <= set(CHANNELS)


def test_fixes_bring_velocity_and_altitude_together() -> None:
    assert numbers_from("gps") == ("velocity_north", "velocity_east", "velocity_down", "altitude")
