"""The laboratory folder: settings, participants and the next session."""
