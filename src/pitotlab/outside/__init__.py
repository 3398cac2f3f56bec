"""A generator of flights that shares no code with the product, and the judge of its calibration."""
