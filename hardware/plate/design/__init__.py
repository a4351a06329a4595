"""Design of plates: from requirements to sizes."""
