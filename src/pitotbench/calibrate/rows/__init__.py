"""From the log to what is fitted: usable rows, screened, in blocks. Arrays are SI and radians."""
