"""The rates at which a flight is integrated: the usual one, and which others a case may ask for.

A flight at 40 Hz takes 0.4 of the time of one at 100 Hz. docs/speed.md measures what it changes.
"""

USUAL_RATE = 100.0  # Hz
SLOWEST_RATE = 40.0  # Hz: at 20 Hz an autopilot loses a light airplane
LOOKS = 10.0  # Hz: a card looks at its instruments once in a whole number of steps


def possible_rates() -> tuple[float, ...]:
    """Return the rates [Hz] at which a flight may be integrated, the slowest first."""
    steps = range(round(SLOWEST_RATE / LOOKS), round(USUAL_RATE / LOOKS) + 1)
    return tuple(LOOKS * step for step in steps)


def rates_for(air_rate: float) -> tuple[float, ...]:
    """Return the rates [Hz] of integration that fit an air-data rate [Hz], the slowest first.

    They are its whole multiples, so that each row is a step of the flight. The usual rate fits every data system:
    rows that fall between two of its steps are interpolated.
    """
    return tuple(rate for rate in possible_rates() if rate == USUAL_RATE or (rate / air_rate).is_integer())


def rate_problem(rate: float, air_rate: float | None = None) -> str | None:
    """Return why a flight is not integrated at a rate [Hz], for air data of a rate [Hz] if given; None if it is."""
    if rate not in possible_rates():
        known = ", ".join(f"{each:g}" for each in possible_rates())
        return f"a flight is integrated at {known} Hz, not at {rate:g} Hz"
    if air_rate is None or rate in rates_for(air_rate):
        return None
    fitting = " or ".join(f"{each:g}" for each in rates_for(air_rate))
    return (
        f"{rate:g} Hz is not a whole multiple of the {air_rate:g} Hz of the air data: "
        f"integrate the flight at {fitting} Hz"
    )
