"""The channels of the air-data bus. A fault of the bus changes them together."""

AIR_DATA = ("impact_pressure", "static_pressure", "total_temperature")
