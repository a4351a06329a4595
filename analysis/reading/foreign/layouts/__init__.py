"""Reshape the layouts of other laboratories' tables, with one module per kind of layout."""
