"""What each page shows: from a snapshot to values of a template."""
