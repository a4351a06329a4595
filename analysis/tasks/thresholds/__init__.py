"""Thresholds from forced choice and constant stimuli."""
