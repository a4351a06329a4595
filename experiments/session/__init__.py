"""Run sessions: perform a protocol's steps with plate, participant and journal."""
