"""Drive a plate with a sound card."""
