"""Build a BIDS data set from journals: columns, trials and files."""
