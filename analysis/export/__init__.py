"""Export an analysis for a manuscript and its reviewers: Word, PDF, scripts that recompute it."""
