"""Calibration of a plate: sweep, fit, record, plot."""
