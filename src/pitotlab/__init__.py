"""The laboratory: what proves the product. Never in the wheel."""
