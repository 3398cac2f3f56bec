"""What a curve and a wind predict for each row, together with the systematic errors.

All arrays are SI and radians; parameters of the error curve are without units.
"""
