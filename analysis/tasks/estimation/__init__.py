"""Magnitude estimation: tests, exponents, order effects, and what the report says of them."""
