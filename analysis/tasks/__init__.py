"""Kinds of task, each in its own subpackage, and the table that lists them."""
