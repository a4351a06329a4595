"""Precision of the other protocols: simulated studies, their answers and the output."""
