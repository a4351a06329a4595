"""Tables for finger sensors, the headphone test, questionnaires and participants."""
