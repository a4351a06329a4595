"""The loop that performs a run's steps with plate, participant and journal."""
