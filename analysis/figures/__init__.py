"""Figures that show squeeze-film predictions."""
