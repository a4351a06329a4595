"""Errors by cause: the user, the rig, or (all other exceptions) Slipscale itself.

The command line turns the first two into one sentence and an exit status. Any other exception is a
defect in Slipscale and keeps its traceback.
"""

from __future__ import annotations


class UserError(Exception):
    """The user's input is wrong; the message names the place and what was expected. Status 2."""


class RigError(Exception):
    """The rig failed; the message names the fault and what to do about it. Exit status 3."""


def harmless(text: str) -> str:
    r"""Return a text with its control characters escaped.

    Study files, answers and file names come from other people. An escape sequence in them could
    clear the terminal or display misleading text.

    >>> harmless("a\x1b[2Jb")
    'a\\x1b[2Jb'
    """
    return "".join(
        each if each.isprintable() or each in "\n\t" else each.encode("unicode_escape").decode()
        for each in text
    )


# Exit statuses of every command.
DONE = 0
ANSWER_IS_NO = 1  # it ran with a negative result: a mismatch, a failed check
USER_FAULT = 2
RIG_FAULT = 3
INTERRUPTED = 130
