"""The channels that come over the air-data bus, which a fault of that bus changes together."""

AIR_DATA = ("impact_pressure", "static_pressure", "total_temperature")
