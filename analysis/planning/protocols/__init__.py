"""Simulate studies with any protocol to estimate their precision and power."""
