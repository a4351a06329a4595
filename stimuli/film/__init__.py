"""The air film under a finger: closed forms, Reynolds equation, periodic film, shared load."""
