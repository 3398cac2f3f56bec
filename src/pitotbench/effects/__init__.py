"""The table of physical effects that a case may name: one small file an effect. It is empty so far, and a case that
names an effect is refused rather than flown without it."""

from pitotbench.catalog import Catalog

EFFECTS: Catalog[object] = Catalog("effect", {})
