"""Code that several kinds of task share."""
