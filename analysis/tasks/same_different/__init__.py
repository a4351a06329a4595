"""Same–different: sensitivity by the differencing model."""
