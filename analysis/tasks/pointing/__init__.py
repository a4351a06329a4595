"""Pointing (Fitts's law): throughput, and movement time by index of difficulty."""
