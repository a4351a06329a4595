"""The output of a plate: its state, and the guard that switches it off when a session cannot."""
