"""The commands `slipscale plate ...`, one module each, loaded on demand."""
