"""Read and write flight logs: our own as CSV, Parquet and .mat, foreign ones by a mapping.

Column names of our own end in their units.
"""

from pitotbench.logbook.columns import QUANTITIES as QUANTITIES
from pitotbench.logbook.columns import atomic as atomic
from pitotbench.logbook.columns import write_text as write_text
from pitotbench.logbook.flight_parts import flights_in as flights_in
from pitotbench.logbook.formats import FORMATS as FORMATS
from pitotbench.logbook.formats import write_log as write_log
from pitotbench.logbook.mapping import find_mapping as find_mapping
from pitotbench.logbook.mapping import shipped as shipped_mappings
from pitotbench.logbook.reading import read_log as read_log

__all__ = [
    "FORMATS",
    "QUANTITIES",
    "atomic",
    "find_mapping",
    "flights_in",
    "read_log",
    "shipped_mappings",
    "write_log",
    "write_text",
]
