"""Carry out complete runs (laboratory sessions and pilots), and the checks before a session."""
