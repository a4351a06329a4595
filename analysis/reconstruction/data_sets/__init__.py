"""The data sets that a published table allows: constraints, counts, samples and witnesses."""
