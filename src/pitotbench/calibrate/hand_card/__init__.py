"""A card written by hand: corrections of its points, a curve a configuration, slips of the pencil.

All arrays are SI and radians; parameters of the error curve are without units.
"""
