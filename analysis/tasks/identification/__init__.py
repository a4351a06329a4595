"""Identification: the confusion matrix and the information transferred."""
