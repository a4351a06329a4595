"""Kinds of questions, one module per kind."""
