"""One folder for each kind of task, and the table that lists them."""
