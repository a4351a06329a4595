"""A person at a PsychoPy window.

Five concepts, one a file: what a screen shows (`scene`), how each step behaves (`screens`), both
without PsychoPy; the window that draws (`display`) and the keyboard that listens (`keyboard`);
and `window`, which joins them into a participant. PsychoPy is imported when the window opens, not
before.
"""

from slipscale.experiments.participants.psychopy_window.display import check_screen, screens
from slipscale.experiments.participants.psychopy_window.window import PsychoPyWindow

__all__ = ["PsychoPyWindow", "check_screen", "screens"]
