"""Orders of surfaces: the rules, their designs, and the random numbers that they draw."""
