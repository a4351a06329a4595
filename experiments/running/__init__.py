"""Runs from beginning to end: in the laboratory, as a pilot, and the check before."""
