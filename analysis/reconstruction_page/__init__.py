"""Write an HTML page about all data sets consistent with a published table."""
