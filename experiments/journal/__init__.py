"""The journal, an append-only record of a run, and functions that read it."""
