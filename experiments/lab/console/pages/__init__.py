"""The contents of the pages, derived from a snapshot as values for the templates."""
