"""From evidence to a verdict: weigh, name, close, patch, advise."""
