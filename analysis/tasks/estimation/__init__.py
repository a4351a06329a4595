"""Magnitude estimation: tests, exponents, order effects and report sections."""
