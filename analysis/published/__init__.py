"""What the paper printed, and tables that it allows: the one place of its numbers."""
