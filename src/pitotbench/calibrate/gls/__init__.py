"""The covering fit: generalized least squares with the noise estimated from the log."""
