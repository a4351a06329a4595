"""Judgements against measured friction."""
