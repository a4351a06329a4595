"""Dissimilarity ratings of pairs, analysed by multidimensional scaling."""
