"""What protocols share: comparisons, rated surfaces, adaptive options, pacing and repeats."""
