"""Commands for running sessions and for study files, each imported only when it is called."""
