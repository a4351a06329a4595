"""Figures of squeeze-film predictions."""
