"""Effects in the data system: clocks, samples, word lengths, and sensors other than pressure."""
