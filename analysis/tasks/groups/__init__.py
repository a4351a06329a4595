"""Compare groups of participants."""
