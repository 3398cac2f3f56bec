"""`--model auto`: the models of the error curve, weighed by evidence."""
