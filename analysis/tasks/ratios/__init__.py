"""Ratio judgements against a standard."""
