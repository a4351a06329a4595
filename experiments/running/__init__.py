"""Runs from start to end: laboratory sessions, pilots, and the checks before a session."""
