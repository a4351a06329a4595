"""The commands that run sessions and handle study files; each is loaded when it is called."""
