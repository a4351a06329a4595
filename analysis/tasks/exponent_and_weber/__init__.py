"""Compare the exponent and the Weber fraction of the same participants."""
