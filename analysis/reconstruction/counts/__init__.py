"""Count the data sets with a given sum and sum of squares, using tables of states."""
