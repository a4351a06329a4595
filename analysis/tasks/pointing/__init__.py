"""Pointing (Fitts): effective width, throughput, and movement time by index of difficulty."""
