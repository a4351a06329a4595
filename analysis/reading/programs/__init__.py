"""Read files of other programs, one module per program."""
