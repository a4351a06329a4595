"""Magnitude estimation: tests, exponents, order effects, and their sections of the report."""
