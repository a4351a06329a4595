"""Errors, split by who is at fault: the user, the rig, or (all others) Slipscale itself.

The front door turns the first two into one sentence and an exit status; anything else is a
defect of ours and keeps its traceback.
"""

from __future__ import annotations


class UserError(Exception):
    """The user's input is wrong: says what, where and what was expected. Exit status 2."""


class RigError(Exception):
    """The rig failed: says what failed and what to do about it. Exit status 3."""


def harmless(text: str) -> str:
    r"""Return a text with its control characters shown, not obeyed by a terminal.

    Study files, answers and file names are other people's: an escape sequence in them could clear
    the screen or write what was never said.

    >>> harmless("a\x1b[2Jb")
    'a\\x1b[2Jb'
    """
    return "".join(
        each if each.isprintable() or each in "\n\t" else each.encode("unicode_escape").decode()
        for each in text
    )


# Exit statuses of every command.
DONE = 0
ANSWER_IS_NO = 1  # it ran, and the answer is no: a mismatch, a failed check
USER_FAULT = 2
RIG_FAULT = 3
INTERRUPTED = 130
