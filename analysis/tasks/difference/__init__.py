"""Descending difference task: yes/no answers and verbal reports."""
