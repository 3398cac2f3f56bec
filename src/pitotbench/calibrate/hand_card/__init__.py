"""A card written by hand: corrections of its points, a curve a configuration, slips of the pencil."""
