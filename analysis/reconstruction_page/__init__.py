"""One page on all data sets behind a published table."""
