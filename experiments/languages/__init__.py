"""Texts for participants, one file per language."""
