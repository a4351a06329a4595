"""Kinds of task that other packages declare, and the short form of a declaration."""
