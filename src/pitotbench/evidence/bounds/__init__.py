"""Coverage of the bounds: over seeds, over truths outside the models, beside other methods."""
