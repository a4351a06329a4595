"""Count, sample and list the data sets that are consistent with a published table."""
