"""Effects in the airframe: drag, mass, trim, controls."""
