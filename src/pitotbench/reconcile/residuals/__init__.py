"""From the log to residuals: what the model predicts for each channel, with the free parameters beside it."""
