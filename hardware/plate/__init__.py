"""Models of the plate: materials, beam, finite elements and dynamics."""
