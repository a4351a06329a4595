"""Dissimilarity ratings of pairs and free sorting, analysed by multidimensional scaling."""
