"""Provide the results printed in the paper."""
