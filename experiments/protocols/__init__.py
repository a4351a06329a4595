"""Protocols: plain generators of steps, one file per protocol, registered as entry points."""
