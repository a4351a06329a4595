"""What declarations of kinds of task share."""
