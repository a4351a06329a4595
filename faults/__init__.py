"""Define errors caused by the user or by the rig; other exceptions are defects in Slipscale.

The command line reports these errors in one sentence and with an exit status. All other exceptions
are printed with their traceback.
"""

from __future__ import annotations

from slipscale.faults.message import Message


class _Reported(Exception):
    """Error whose `Message` is created from a template and values; ``str(error)`` returns it."""

    def __init__(self, template: str, /, **values: object) -> None:
        super().__init__(Message(template, **values) if values else template)


class UserError(_Reported):
    """Exception raised for invalid user input. The message states which input is expected."""


class RigError(_Reported):
    """Exception raised for failures of the rig. The message states the fault and a remedy."""


def harmless(text: str) -> str:
    r"""Escape the control characters in a text.

    Study files, answers and file names may contain escape sequences, which could clear the terminal
    or display misleading text.

    >>> harmless("a\x1b[2Jb")
    'a\\x1b[2Jb'
    """
    if isinstance(text, Message) and text.values:
        found = text.values.items()
        return Message(
            text.template, **{k: harmless(v) if isinstance(v, str) else v for k, v in found}
        )
    return "".join(
        each if each.isprintable() or each in "\n\t" else each.encode("unicode_escape").decode()
        for each in text
    )


# Exit statuses of all commands.
DONE = 0
ANSWER_IS_NO = 1  # negative result, such as a mismatch or a failed check
USER_FAULT = 2
RIG_FAULT = 3
INTERRUPTED = 130
