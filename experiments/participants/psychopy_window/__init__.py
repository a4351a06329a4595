"""The participant's window, which uses PsychoPy.

The contents of a screen (`scene`) and the behaviour of each step (`screens`) are independent of
PsychoPy. PsychoPy is used by the drawing window (`display`), by the keyboard (`keyboard`), and by
`window`, which combines both into a participant.
"""

from slipscale.experiments.participants.psychopy_window.display import check_screen, screens
from slipscale.experiments.participants.psychopy_window.window import PsychoPyWindow

__all__ = ["PsychoPyWindow", "check_screen", "screens"]
