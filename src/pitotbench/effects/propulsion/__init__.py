"""Effects in engines, propellers and their gauges."""
