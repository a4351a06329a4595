"""Scales from comparisons: Bradley-Terry, Thurstone, difference scaling, transitivity."""
