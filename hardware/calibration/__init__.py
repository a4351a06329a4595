"""Calibration of a plate: sweep, fit, record and plot."""
