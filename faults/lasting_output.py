"""Write to a terminal that may lack characters, be full, or be closed.

Nothing on the operator's side may stop a session, so output never raises an error. Rules:

- A character that the terminal's encoding lacks is written as ``?``.
- After a write has failed, later output is discarded, and the command goes on. So is the output to
  a stream that was closed from the beginning.
- At the end, `lost` tells why output was lost. A reader that closes a pipe, such as ``head``, has
  what it wanted, so this is no loss.
"""

from __future__ import annotations

import os
import sys
from io import TextIOWrapper
from pathlib import Path


class LastingOutput:
    """A text stream whose writes never fail; everything else is that of the stream.

    Attributes
    ----------
    lost : str
        Why output was lost; empty if everything was written, or if a pipe's reader closed it.
    """

    def __init__(self, stream: TextIOWrapper) -> None:
        stream.reconfigure(errors="replace")
        self._stream = stream
        self.lost = ""

    def write(self, text: str) -> int:
        """Write text, or discard it if the stream can no longer be written."""
        try:
            return self._stream.write(text)
        except OSError as error:
            self._discard(error)
            return len(text)

    def flush(self) -> None:
        """Write what is buffered, or discard it."""
        try:
            self._stream.flush()
        except OSError as error:
            self._discard(error)

    def _discard(self, error: OSError) -> None:
        if not isinstance(error, BrokenPipeError):
            self.lost = error.strerror or str(error)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._stream.fileno())
        os.close(nowhere)

    def __getattr__(self, name: str) -> object:
        """Return any other attribute of the stream, such as its encoding."""
        return getattr(self._stream, name)


def last() -> None:
    """Let the standard streams of this process last; replacements stay."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # closed from the beginning
            nowhere = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115 - it lasts
            setattr(sys, name, nowhere)
        elif isinstance(stream, TextIOWrapper):
            setattr(sys, name, LastingOutput(stream))
