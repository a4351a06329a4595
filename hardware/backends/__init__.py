"""Backends of the plate driver, found by entry point."""
