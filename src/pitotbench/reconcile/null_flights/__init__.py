"""What null flights (flights without an effect) show by chance: the noise, and the spread of every score."""
