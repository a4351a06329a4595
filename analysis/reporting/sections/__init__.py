"""Sections of the report, each written from the analysis."""
