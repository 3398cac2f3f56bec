"""Effects in the air that the aircraft flies through."""
