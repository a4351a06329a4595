"""Adaptive methods: select the next level from the answers so far.

A method is a frozen rule that starts a *track*. A track is a frozen state: it provides the next
level and, given an answer, returns its next state. Nothing here depends on a clock, a screen or a
plate, so a run can be reproduced exactly from its answers.
"""
