"""What the finger does on the plate: where it is, and the forces between the two."""
