"""What to fly next: the maneuver in which two explanations differ most, or in which a size shows best."""

from collections.abc import Sequence

DIAGNOSTIC = "diagnostic (climb, descent, steady sideslips, turn, idle and back: 6 minutes)"

# What makes an effect of each kind show, by what its signature needs.
SHOWS: dict[str, tuple[tuple[str, ...], str]] = {
    "changing airspeed": (
        ("pitot_lag", "hysteresis", "gps_latency", "clock_drift", "water_in_line"),
        "repeated decelerations and accelerations (rapid_decel), both ways",
    ),
    "changing height": (
        (
            "static_lag",
            "line_leak",
            "wind_shear",
            "temperature_drift",
            "nonstandard_temperature",
            "static_zero_offset",
        ),
        "a climb and a descent at constant airspeed (diagnostic)",
    ),
    "turning": (
        ("turn_drag", "induced_drag", "antenna_lever_arm", "mass", "wind_drift", "sea_breeze_front"),
        "a full circle at 30° of bank, both ways (circle)",
    ),
    "sideslip": (
        ("sideslip_static_error", "control_effectiveness"),
        "steady-heading sideslips to both sides (diagnostic)",
    ),
    "power at constant airspeed": (
        ("propwash_error", "power_deficit", "propeller_efficiency", "manifold_pressure_gauge", "throttle_rigging"),
        "level flight at one airspeed with high and low power (climb, then descend)",
    ),
    "angle of attack": (
        ("alpha_static_error", "flap_not_up", "gear_not_up", "belly_pod", "center_of_gravity", "trim_offset"),
        "level flight from the highest to the lowest airspeed (four_leg)",
    ),
    "temperature": (
        ("recovery_deficit", "temperature_bias"),
        "legs on reciprocal headings at the highest and lowest airspeed (race_track), and a balloon's temperature",
    ),
}


def advice(kind: str, groups: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """Sentences for a verdict: `groups` holds, for each effect that was found, its name and those it is confused
    with."""
    if kind == "no_gap":
        return ("nothing to separate; the smallest sizes that would have shown are listed",)
    if kind == "unknown":
        return (
            "repeat the maneuver: a gap that returns in the same channel and phase is the airplane's or the "
            "system's, one that does not is the day's",
        )
    return tuple(_for_group(group) for group in groups)


def _for_group(names: Sequence[str]) -> str:
    kinds = {n: next((k for k, (members, _) in SHOWS.items() if n in members), "") for n in names}
    if len(names) == 1:
        kind = kinds[names[0]]
        return f"to sharpen {names[0]}: " + (SHOWS[kind][1] if kind else "a longer log of the same maneuver")
    told = sorted({kind for kind in kinds.values() if kind})
    listed = ", ".join(names)
    if len(told) < 2:
        where = SHOWS[told[0]][1] if told else "a longer log"
        return f"{listed} act alike in any maneuver of this kind; look at the airplane, or sharpen both by: {where}"
    return f"to tell {listed} apart: fly {DIAGNOSTIC}; or " + "; or ".join(SHOWS[kind][1] for kind in told)
