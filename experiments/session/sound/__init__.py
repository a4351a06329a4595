"""Sounds of a session: masking noise, and the sounds of questions."""
