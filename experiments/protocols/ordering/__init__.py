"""Orders of surfaces: the rules, their designs, and their random numbers."""
