"""Adaptive methods, which select each level from the answers given so far.

A method is an immutable rule that starts a *track*. A track is an immutable state: it provides the
next level and, given an answer, returns the following state. Methods do not depend on a clock, a
screen or a plate, so a run can be reproduced exactly from its answers.
"""
