"""Constraints, counts, samples and examples of the data sets that a published table allows."""
