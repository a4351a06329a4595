"""An emulated driver board: the firmware's behaviour on a pseudo-terminal."""
