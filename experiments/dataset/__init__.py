"""Build a BIDS data set from journals."""
