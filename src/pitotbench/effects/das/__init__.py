"""Effects in the data system: clocks, samples, words, sensors other than pressure."""
