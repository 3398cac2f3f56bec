"""From residuals and signatures to a verdict: weigh, name, close, patch, advise.

Units: rows and columns are whitened, so that they are in units of the noise; sizes and their deviations are in the
unit of each parameter in the table of effects.
"""
