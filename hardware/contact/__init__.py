"""Measure the position and the forces of the finger on the plate."""
