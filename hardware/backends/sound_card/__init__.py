"""A plate driven by a sound card."""
