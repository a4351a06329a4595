"""Check that a driver board follows docs/reference/board-protocol.md: `slipscale plate conform`."""
