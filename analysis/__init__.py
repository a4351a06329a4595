"""Data sets to numbers, figures and a report."""
