"""Free sorting, analysed by multidimensional scaling."""
