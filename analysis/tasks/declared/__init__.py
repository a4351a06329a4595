"""Code shared by the declarations of kinds of task."""
