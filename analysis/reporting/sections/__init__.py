"""Sections of the report: each takes the analysis and returns headings, tables, figures."""
