"""Thresholds from forced choice."""
