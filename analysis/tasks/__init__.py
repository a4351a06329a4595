"""The kinds of tasks, one folder each, and the table that lists them."""
