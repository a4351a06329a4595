"""Implement the analysis commands, one module per command."""
