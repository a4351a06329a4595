"""Simulated participants: populations, the answers of each person, and runs."""
