"""What happens with a participant: studies, protocols, sessions, journals, data sets."""
