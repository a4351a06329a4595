"""Write and read journals, the append-only records of runs."""
