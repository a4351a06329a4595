"""Session steps that consist of several actions."""
