"""Carry out complete runs: laboratory sessions, pilots, and the checks before a session."""
