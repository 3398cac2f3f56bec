"""Say what to fly so that an effect shows: the motions that excite it, and the maneuvers that contain them."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Excitation:
    """A way of flying that makes an effect show.

    `maneuvers` are names of the table of maneuvers, the best one first. `text` describes the flying in words.
    """

    maneuvers: tuple[str, ...]
    text: str

    def __str__(self) -> str:
        return f"{self.text} ({', '.join(self.maneuvers)})"


CHANGING_AIRSPEED = Excitation(
    ("rapid_decel",), "idle decelerations on opposite headings, and the acceleration between them"
)
CHANGING_HEIGHT = Excitation(("diagnostic",), "a climb and a descent at constant airspeed")
TURNING = Excitation(("circle", "figure_eight"), "full circles at 30° of bank to one side, or at 45° to both")
SIDESLIP = Excitation(("diagnostic",), "steady-heading sideslips to both sides")
POWER = Excitation(("diagnostic",), "one airspeed with high and low power, in a climb and a descent")
RANGE_OF_AIRSPEED = Excitation(("four_leg",), "level flight from the highest to the lowest airspeed")
STEPS_OF_AIRSPEED = Excitation(
    ("step_decrease", "step_both_ways"), "level flight in small steps of airspeed, both ways"
)
STEADY_LEGS = Excitation(("race_track",), "long level legs at constant airspeed and power")
EARLY_AND_LATE = Excitation(("race_track",), "the same airspeeds early and late in one long log")
TEMPERATURE = Excitation(
    ("race_track",),
    "legs on reciprocal headings at the highest and lowest airspeed, with a balloon's temperature",
)
