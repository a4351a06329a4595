"""Freeze a study and its analysis before data collection, and compare analyses with the plan."""
