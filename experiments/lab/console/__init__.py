"""The laboratory console: pages on this machine that show and steer what sessions do."""
