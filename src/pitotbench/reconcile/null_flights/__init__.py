"""What residuals look like without any effect, learned from flights of the same card."""
