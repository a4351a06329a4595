"""Method of limits: transitions of ascending and descending series."""
