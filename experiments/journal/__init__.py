"""The append-only record of a run, and what can be read from it."""
