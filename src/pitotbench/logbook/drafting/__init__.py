"""Draft a mapping for a log whose columns have unknown names."""

from pitotbench.logbook.drafting.draft_mapping import DraftedMapping as DraftedMapping
from pitotbench.logbook.drafting.draft_mapping import draft_mapping as draft_mapping
from pitotbench.logbook.drafting.mapping_text import mapping_text as mapping_text
