"""The texts that participants read, one file per language."""
