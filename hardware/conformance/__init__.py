"""Whether a driver board follows docs/board-protocol.md: `slipscale plate conform`."""
