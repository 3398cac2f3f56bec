"""Flights in numbers: the plan file, the workers, the store, the table of results."""
