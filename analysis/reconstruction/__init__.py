"""Every raw data set that a published table of n, mean and standard deviation allows."""
