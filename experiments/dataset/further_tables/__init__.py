"""Data other than trials: finger, headphones, questionnaires, participants."""
