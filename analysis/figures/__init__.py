"""Draw figures of squeeze-film predictions."""
