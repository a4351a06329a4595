"""Groups of participants compared."""
