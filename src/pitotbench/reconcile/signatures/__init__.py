"""What each effect of the table would change in the residuals of a log."""
