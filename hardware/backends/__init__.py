"""Provide the backends of the plate driver, which are registered as entry points."""
