"""Same–different task: sensitivity from the differencing model."""
