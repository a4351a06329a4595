"""Tables other than those of the trials: finger, headphones, questionnaires, people."""
