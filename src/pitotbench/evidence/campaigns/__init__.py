"""The measurements behind docs/scale.md: what a campaign survives, and what it costs."""
