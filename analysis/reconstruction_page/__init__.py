"""Write an HTML page about all data sets that are consistent with a published table."""
