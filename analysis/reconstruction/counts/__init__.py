"""How many data sets have a sum and a sum of squares: the tables of states that counting walks."""
