"""From raw estimates to one scale and to logarithms; data quality before anything is tested."""
