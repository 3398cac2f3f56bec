"""From a log to residuals: measured less predicted for each channel, and the free parameters of every log.

Units: tracks and motions are in SI units and radians, residuals in the unit of their channel
(`predicted_channels.UNITS`), and what is whitened in units of the noise.
"""
