"""Export an analysis for a manuscript and reviewers: Word, PDF and scripts that recompute it."""
