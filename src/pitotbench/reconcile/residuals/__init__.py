"""From a log to residuals: measured less predicted for each channel, and the free parameters of every log."""
