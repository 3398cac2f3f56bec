"""Find a formula for a gap that no effect of the table explains."""
