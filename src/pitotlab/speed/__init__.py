"""Measure ratios of CPU times, which depend less on the machine than the times do."""
