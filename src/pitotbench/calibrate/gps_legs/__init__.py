"""Fixed-speed GPS methods: legs and turns at one airspeed, without a model of the curve."""
