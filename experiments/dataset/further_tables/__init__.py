"""Tables of the finger, the headphone test, questionnaires and participants."""
