"""Simulated participants: the population, each person's answers, and their runs."""
