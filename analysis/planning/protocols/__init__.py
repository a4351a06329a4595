"""Estimate the precision and power of studies with any protocol, by simulation."""
