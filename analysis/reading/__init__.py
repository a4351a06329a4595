"""Data sets and tables by hand, read into one frozen `dataset.Dataset`."""
