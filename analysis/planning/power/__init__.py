"""Estimate the power of tests for differences between amplitudes, by simulation."""
