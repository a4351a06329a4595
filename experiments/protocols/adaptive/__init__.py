"""Adaptive methods: which level comes next, from the answers so far.

A method is a frozen rule that starts a *track*; a track is a frozen state that tells the next
level and, sent an answer, returns the track after it. Nothing here knows a clock, a screen or a
plate, so a run is repeated to the bit from its answers.
"""
