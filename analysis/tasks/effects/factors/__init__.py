"""Factors crossed with the levels in magnitude estimation."""
