"""The commands of the analysis, one module each, loaded when called."""
