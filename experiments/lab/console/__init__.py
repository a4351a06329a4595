"""The laboratory console: web pages on this computer that show and control running sessions."""
