"""Statistics: functions of prepared data, each returning its numbers or the reason why not."""
