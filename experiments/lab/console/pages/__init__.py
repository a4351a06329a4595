"""Page contents: functions that turn a snapshot into template values."""
