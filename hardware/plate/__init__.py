"""Model plates: materials, beam, finite elements and dynamics."""
