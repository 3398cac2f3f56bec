"""Compare, identify and measure flight models; nothing of a calibration imports them."""
