"""Build a page about all data sets behind a published table."""
