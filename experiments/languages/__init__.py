"""Text shown to participants, one file per language."""
