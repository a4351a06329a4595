"""Analyse data sets, and write result files, figures and a report."""
