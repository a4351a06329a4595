"""Participants: people at a PsychoPy window, simulated participants and scripted participants."""
