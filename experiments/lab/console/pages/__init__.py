"""Page contents: values for the templates, derived from a snapshot."""
