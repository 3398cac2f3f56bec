"""The table of physical effects: one small file an effect."""
