"""Identification: confusion matrix and transferred information."""
