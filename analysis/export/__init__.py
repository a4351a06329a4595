"""An analysis for a manuscript and for whoever checks it: Word, PDF, scripts that recompute it."""
