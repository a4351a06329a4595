"""Dissimilarity ratings of pairs, by multidimensional scaling."""
