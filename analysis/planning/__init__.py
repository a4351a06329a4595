"""Planning a study: how many participants."""
