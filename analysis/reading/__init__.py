"""Read data sets and other tables into one frozen `dataset.Dataset`."""
