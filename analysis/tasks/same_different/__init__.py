"""Same–different task, analysed with the differencing model."""
