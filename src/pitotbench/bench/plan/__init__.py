"""Plan a flight: predict the bound of each maneuver before it is flown, and find the card with the smallest one."""
