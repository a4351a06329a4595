"""State what the columns of a table mean: mapping, rules of layouts, and keywords."""
