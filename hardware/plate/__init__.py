"""Models of the plate: materials, beam, finite elements, dynamics."""
