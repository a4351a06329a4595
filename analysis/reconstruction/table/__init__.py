"""Represent a published table: columns as printed and as read, and contradictions."""
