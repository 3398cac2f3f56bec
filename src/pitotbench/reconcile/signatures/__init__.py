"""What each effect of the table would change in the residuals of a log.

Units: changes are in the unit of their residual channel, sizes in that of the parameter in the table of effects.
"""
