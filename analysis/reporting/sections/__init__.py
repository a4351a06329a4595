"""Sections of the report, each computed from an analysis."""
