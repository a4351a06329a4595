"""Commands of the analysis, one module each, imported when called."""
