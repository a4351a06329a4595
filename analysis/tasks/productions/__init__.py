"""Magnitude production."""
