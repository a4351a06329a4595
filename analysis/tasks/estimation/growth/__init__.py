"""How estimates grow with amplitude."""
