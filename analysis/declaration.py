"""Define declarations: objects that a module defines once, each as the instance of its own class.

The methods and attributes of the class are the content of a declaration, so it is pickled as the
name of its class.
"""

from __future__ import annotations


class Declaration:
    """A declaration, which is equal to the copy that another process unpickles."""

    def __eq__(self, other: object) -> bool:
        """Compare the classes, and attributes that were set when the instances were created."""
        return type(self) is type(other) and vars(self) == vars(other)

    def __hash__(self) -> int:
        """Return the same value for all instances of a class."""
        return hash(type(self))
