"""Represent a published table: its columns, as printed and as read, and its contradictions."""
