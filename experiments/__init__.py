"""Experiments with participants: studies, protocols, sessions, journals and data sets."""
