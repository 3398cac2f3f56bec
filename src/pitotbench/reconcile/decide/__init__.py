"""From residuals and signatures to a verdict: weigh, name, close, patch, advise."""
