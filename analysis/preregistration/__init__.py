"""Freeze the plan of a study before data collection, and compare analyses with the plan."""
