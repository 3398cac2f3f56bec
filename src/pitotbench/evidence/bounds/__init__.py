"""Measure the coverage of the bounds: over seeds, for truths outside the models, and against other methods."""
