"""Backends of the plate driver, registered as entry points."""
