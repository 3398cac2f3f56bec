"""Good logs broken in known ways, and how the product tells them."""
