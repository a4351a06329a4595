"""Present results as files, sentences, pages and terminal output."""
