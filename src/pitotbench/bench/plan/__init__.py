"""What to fly: the bound that a maneuver will give, before it is flown, and the card that gives the best one."""
