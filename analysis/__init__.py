"""Analyse data sets and write numbers, figures and a report."""
