"""Fit thresholds and slopes: psychometric functions of each participant and of the population."""
