"""Screens of questions, as plain data and independent of any window or clock."""
