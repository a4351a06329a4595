"""The commands that run sessions and handle study files; loaded when called."""
