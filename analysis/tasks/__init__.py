"""One folder per kind of task, and the table that lists them."""
