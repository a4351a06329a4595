"""Participant's window, based on PsychoPy.

The contents of a screen (`scene`) and the behaviour of each step (`screens`) are independent of
PsychoPy. Only `display`, `keyboard` and `window` use PsychoPy.
"""

from slipscale.experiments.participants.psychopy_window.display import check_screen, screens
from slipscale.experiments.participants.psychopy_window.window import PsychoPyWindow

__all__ = ["PsychoPyWindow", "check_screen", "screens"]
