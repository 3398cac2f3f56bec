"""Effects between the pressure ports and the transducers."""
