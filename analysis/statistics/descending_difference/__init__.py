"""The descending difference: who said yes at which step, d', and what was said in words."""
