"""The plate as a machine: driver interface, backends, calibration, models."""
