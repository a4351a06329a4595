"""Parts shared by protocols: comparisons, rated surfaces, adaptive options, pacing and repeats."""
