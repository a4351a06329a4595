"""Magnitude estimation: tests, exponents, order effects, and their report sections."""
