"""Results as files, sentences, pages and terminal output."""
