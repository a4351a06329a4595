"""Tests of repeated measures: all levels at once, two factors, and pairs of levels."""
