"""Slipscale's protocols: plain generators of steps, one file each, registered as entry points."""
