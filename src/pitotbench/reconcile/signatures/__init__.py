"""What each effect would do to the residuals of this flight."""
