"""Fit psychometric functions for each participant and for the population."""
