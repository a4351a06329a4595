"""The plate: driver interface, backends, calibration and models."""
