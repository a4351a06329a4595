"""Effects of groups, sessions, experimental factors and measured friction on the answers."""
