"""Power of the amplitude tests: the grid of conditions, its simulated studies, and the output."""
