"""A study simulated many times: how far its whole table of results may vary."""
