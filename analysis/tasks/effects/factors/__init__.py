"""Experimental factors that are crossed with the levels in magnitude estimation."""
