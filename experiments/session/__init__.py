"""Run sessions: carry out a protocol's steps with a plate, a participant and a journal."""
