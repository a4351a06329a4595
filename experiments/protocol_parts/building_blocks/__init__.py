"""Building blocks that several protocols share: comparisons, ratings, pacing, repeats and so on."""
