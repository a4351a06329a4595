"""Plan the number of participants in a study."""
