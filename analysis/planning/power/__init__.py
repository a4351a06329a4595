"""Simulate studies to estimate the power of tests for differences between amplitudes."""
