"""A laboratory's own analyses: plug-ins that get the data set and return a typed result."""
