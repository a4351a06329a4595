"""From requirements to plate sizes."""
