"""Analyse data sets: numbers, figures and a report."""
