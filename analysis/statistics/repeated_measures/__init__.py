"""Tests for repeated measures: overall tests, two-factor tests and pairwise comparisons."""
