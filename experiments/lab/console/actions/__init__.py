"""The actions that a page can request."""
