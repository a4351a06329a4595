"""Plate support for PsychoPy Builder: a routine component and a device manager backend."""
