"""Tables of data other than trials: finger, headphones, questionnaires, participants."""
