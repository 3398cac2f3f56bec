"""Estimators, with numbers without units, or in the units of the data that the caller passes."""
