"""Ratings on a visual analogue scale."""
