"""Custom simulated people: classes from other packages that modify Slipscale's simulated person.

The package registers its class as an entry point in the group ``slipscale.participants``. The entry
point's name can then be passed to ``slipscale pilot --population`` or used in a population file.
"""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Mapping
from importlib.metadata import EntryPoint
from typing import TYPE_CHECKING, ClassVar, NamedTuple, TypeVar

from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.plug_ins import PARTICIPANTS, installed, package_of
from slipscale.faults.plug_ins import called as watched

if TYPE_CHECKING:
    from slipscale.experiments.steps.simulated_person import SimulatedPerson
    from slipscale.experiments.steps.steps import Ask, Explore

    Person = SimulatedPerson
else:
    Person = object  # the protocol's empty methods would hide those of the person

T = TypeVar("T")


class Behaviour(Person):
    """Base class for custom simulated people; override properties and methods of `SimulatedPerson`.

    Everything that is not overridden is Slipscale's simulated person's: `self.person` has the
    original methods. Draw random numbers only from ``stream``. Otherwise, the answers of an
    interrupted and resumed pilot may change.

    Parameters
    ----------
    person : SimulatedPerson
        Slipscale's simulated person.
    """

    #: Parameters that override those of the shipped population; keys as in a population file.
    population: ClassVar[Mapping[str, object]] = {}

    def __init__(self, person: SimulatedPerson) -> None:
        self.person = person

    if not TYPE_CHECKING:  # mypy would accept any name

        def __getattr__(self, name: str) -> object:
            return getattr(vars(self)["person"], name)

    def duration_s(self, step: Explore | Ask, usual_s: float) -> float:  # noqa: ARG002
        """Return the duration of an exploration or answer before the study limits are applied."""
        return usual_s


class InstalledBehaviour(NamedTuple):
    """A class from an installed package, together with its entry point."""

    kind: type[Behaviour]
    point: EntryPoint

    @property
    def named(self) -> str:
        """The name used in messages."""
        package = package_of(self.point)
        return Message(
            "simulated person '{point_name}' of the package {package}",
            point_name=self.point.name,
            package=package,
        )

    def made(self, person: SimulatedPerson) -> Behaviour:
        """Return an instance of the class."""
        return self.ask(lambda: self.kind(person))

    def ask(self, action: Callable[[], T]) -> T:
        """Call a function of the installed package, and report its exceptions as error messages."""
        return watched(self.point, action, self.named)


def behaviour_names() -> list[str]:
    """Return the sorted names of all behaviours of simulated people from installed packages."""
    return list(installed(PARTICIPANTS))


def load_behaviour(name: str) -> InstalledBehaviour:
    """Return a behaviour of simulated people by name, from the package that provides it.

    Raises
    ------
    UserError
        If no package provides a behaviour with this name, or if it cannot be imported or is not a
        `Behaviour`.
    """
    point = installed(PARTICIPANTS).get(name)
    if point is None:
        raise UserError(
            "simulated person '{name}': no installed package provides it; expected {available}",
            name=name,
            available=" or ".join(behaviour_names())
            or "the package that provides it to be installed",
        )
    subject = Message(
        "simulated person '{name}' of the package {package}",
        name=name,
        package=package_of(point),
    )
    kind: object = watched(point, point.load, subject)
    if not (isinstance(kind, type) and issubclass(kind, Behaviour)):
        raise UserError(
            "{subject}: its entry point is {kind}, expected a class derived from Behaviour",
            subject=subject,
            kind=reprlib.repr(kind),
        )
    return InstalledBehaviour(kind, point)
