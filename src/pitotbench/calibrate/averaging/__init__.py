"""`--model auto`: the models of the error curve, weighed by evidence.

All arrays are SI and radians; parameters of the error curve are without units.
"""
