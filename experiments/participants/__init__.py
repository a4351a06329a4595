"""Participants: a person at a PsychoPy window, a simulated or a scripted participant."""
