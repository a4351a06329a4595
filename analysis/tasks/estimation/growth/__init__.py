"""Growth of estimates with amplitude."""
