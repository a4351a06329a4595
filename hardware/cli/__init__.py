"""The commands `slipscale plate ...`, one module each, loaded when called."""
