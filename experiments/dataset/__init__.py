"""Journals to a BIDS data set: columns, trials, files."""
