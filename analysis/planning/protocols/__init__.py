"""Estimate the precision of the other protocols: simulated studies, answers and output."""
