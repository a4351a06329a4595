"""Calibrate a plate: measure sweeps, fit resonance and gain, store and plot the results."""
