"""The covering fit: generalized least squares with the noise estimated from the log.

All arrays are SI and radians; parameters of the error curve are without units.
"""
