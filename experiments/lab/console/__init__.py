"""The laboratory console: web pages that show and control running sessions."""
