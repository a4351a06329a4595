"""Kinds of task declared by other packages, and a short form of the declaration."""
