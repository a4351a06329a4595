"""Method of limits: transitions in ascending and descending series."""
