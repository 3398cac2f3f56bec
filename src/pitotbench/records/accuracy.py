"""The usual accuracies: 2σ of constant errors of the sensors, which hold where no log, mapping or flag states them.

The bounds of a calibration, the reading of displays and the help text follow. A test holds the pages against them.
Temperature: a calibrated total-temperature probe with its installation. Recovery factor: the spread between probes
of one type. Static pressure: an air-data transducer. GPS velocity: a receiver without corrections.
"""

USUAL_ACCURACIES: dict[str, float] = {
    "temperature_k": 1.5,
    "recovery_factor": 0.02,
    "static_pressure_pa": 30.0,
    "velocity_mps": 0.05,  # of each horizontal component
}
