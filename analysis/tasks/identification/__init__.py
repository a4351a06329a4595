"""Identification: the table of presented and named surfaces, and the information transferred."""
