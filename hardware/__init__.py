"""Drive, calibrate, emulate and model tactile plates."""
