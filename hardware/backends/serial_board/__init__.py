"""Drive a plate through a driver board on a serial line."""
