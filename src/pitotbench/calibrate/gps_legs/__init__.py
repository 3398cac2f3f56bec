"""Fixed-speed GPS methods: legs and turns at one airspeed, without a model of the curve.

All arrays are SI and radians; parameters of the error curve are without units.
"""
