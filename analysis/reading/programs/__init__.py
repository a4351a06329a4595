"""Read files written by other programs, with one module per program."""
