"""The table of channels against those who read it."""

from dataclasses import fields
from typing import get_args

import pytest

from pitotbench.channels import CHANNELS, Channel, Source, numbers_from
from pitotbench.records.case import DataSystem
from pitotbench.records.log import FlightLog
from pitotbench.records.motion import Motion, Reaction
from pitotbench.sensing.recorder import PLAIN
from pitotbench.simulation.properties import PROPERTIES
from pitotbench.units import SUFFIXES

MODEL_ONLY = {
    "mach",
    "temperature_offset",
    "roll_acceleration",
    "pitch_acceleration",
    "yaw_acceleration",
}
every_channel = pytest.mark.parametrize("channel", CHANNELS.values(), ids=lambda c: c.name)


@every_channel
def test_a_line_names_a_known_source_unit_and_sensor(channel: Channel) -> None:
    assert channel.source in get_args(Source)
    assert channel.unit == "" or channel.unit in SUFFIXES
    named = {value for value in (channel.noise, channel.resolution) if isinstance(value, str)}
    assert named <= set(DataSystem.__dataclass_fields__)


def test_logs_the_simulator_motion_and_reaction_speak_of_the_channels_of_the_table() -> None:
    assert [f.name for f in fields(FlightLog)] == [*CHANNELS, "header"]
    assert {channel.name for channel in PLAIN} <= set(PROPERTIES)
    for record in (Motion, Reaction):
        assert {f.name for f in fields(record)} - MODEL_ONLY <= set(CHANNELS)
    # Fixes bring velocity and altitude together.
    assert numbers_from("gps") == ("velocity_north", "velocity_east", "velocity_down", "altitude")
