"""A person at a PsychoPy window.

There is one file per concept. The contents of a screen (`scene`) and the behaviour of each step
(`screens`) are independent of PsychoPy. The window that draws (`display`), the keyboard
(`keyboard`) and `window`, which combines them into a participant, use PsychoPy. PsychoPy is
imported when the window opens, not before.
"""

from slipscale.experiments.participants.psychopy_window.display import check_screen, screens
from slipscale.experiments.participants.psychopy_window.window import PsychoPyWindow

__all__ = ["PsychoPyWindow", "check_screen", "screens"]
