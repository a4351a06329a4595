"""Compute the power of the amplitude tests: grid of conditions, simulated studies and output."""
