"""Export an analysis as Word and PDF files, and as scripts that recompute its numbers."""
