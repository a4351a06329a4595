"""Implement the commands `slipscale plate ...`, with one module per command."""
