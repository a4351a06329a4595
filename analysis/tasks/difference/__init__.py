"""The descending difference: answers of yes and no, and verbal reports."""
