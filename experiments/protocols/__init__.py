"""Protocols: plain generators of steps, one a file, found by entry point."""
