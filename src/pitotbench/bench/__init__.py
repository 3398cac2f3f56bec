"""Fly, sense, calibrate, and compare with the truth.

No other package of the product joins these stages.
"""
