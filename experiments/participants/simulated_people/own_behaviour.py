"""Custom simulated people: classes from other packages that modify Slipscale's simulated person.

The package registers its class as an entry point in the group ``slipscale.participants``. The entry
point's name can then be passed to ``slipscale pilot --population`` or used in a population file.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import EntryPoint
from typing import TYPE_CHECKING, ClassVar, NamedTuple, TypeVar

from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.plug_ins import PARTICIPANTS, installed, package_of
from slipscale.faults.plug_ins import called as watched

if TYPE_CHECKING:
    from slipscale.experiments.steps.simulated_person import Draws, SimulatedPerson
    from slipscale.experiments.steps.steps import Ask, Explore

T = TypeVar("T")


class Behaviour:
    """Base class for custom simulated people; override methods to change the behaviour.

    Draw random numbers only from `stream`. Otherwise, the answers of an interrupted and resumed
    pilot may change.

    Parameters
    ----------
    person : SimulatedPerson
        Slipscale's simulated person.
    """

    #: Parameters that override those of the shipped population; keys as in a population file.
    population: ClassVar[Mapping[str, object]] = {}

    def __init__(self, person: SimulatedPerson) -> None:
        self.person = person

    @property
    def language(self) -> str:
        """Language code of verbal reports."""
        return self.person.language

    @property
    def rises(self) -> bool:
        """Whether the judged attribute increases with the level."""
        return self.person.rises

    @property
    def scale_top(self) -> float:
        """Number that the person would give to the most slippery surface imaginable."""
        return self.person.scale_top

    @property
    def pace(self) -> float:
        """The person's time per action, relative to the median person."""
        return self.person.pace

    @property
    def turned(self) -> int:
        """Net number of notches by which the surface was adjusted in an `Adjust` step."""
        return self.person.turned

    @property
    def felt_again(self) -> int:
        """How often the reference was repeated in an `Adjust` step."""
        return self.person.felt_again

    @property
    def felt_level(self) -> tuple[float, ...]:
        """The levels felt in this trial in µm peak to peak, ordered by interval."""
        return self.person.felt_level

    @property
    def impressions(self) -> tuple[float, ...]:
        """Strengths of the sensations in this trial (0 to 100), with noise."""
        return self.person.impressions

    def usual(self, level: float) -> float:
        """Return the strength of sensation (0 to 100) that the person expects at a level."""
        return self.person.usual(level)

    def pick(self, strengths: Sequence[float]) -> int:
        """Return the index of the surface that the person judges strongest."""
        return self.person.pick(strengths)

    def says_yes(self, strength: float) -> bool:
        """Return whether the person answers "yes" to a difference between impressions."""
        return self.person.says_yes(strength)

    def estimate(self) -> float:
        """Return a magnitude estimate of the last surface, on this person's own scale."""
        return self.person.estimate()

    def rating(self, start: float) -> float:
        """Return a rating of the last surface on a line from 0 to 100."""
        return self.person.rating(start)

    def ratio(self) -> float:
        """Return the strength of the last surface relative to the standard (above 0)."""
        return self.person.ratio()

    def reaches(self, ratio: float) -> bool:
        """Return whether the last surface is at least ``ratio`` times as strong as the standard."""
        return self.person.reaches(ratio)

    def lapses(self) -> bool:
        """Return whether this person answers this question at random (a lapse)."""
        return self.person.lapses()

    def notices(self) -> bool:
        """Return whether the last two surfaces feel different to the person."""
        return self.person.notices()

    def verbal_report(self) -> str:
        """Return the person's verbal report of what disappeared when the level decreased."""
        return self.person.verbal_report()

    def stream(self, *purpose: str | int) -> Draws:
        """Return the random number stream of this person and trial for a purpose."""
        return self.person.stream(*purpose)

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
            "simulated person '{name}': no installed package provides it; expected "
            "{behaviour_names}",
            name=name,
            behaviour_names=" or ".join(behaviour_names())
            or "the package that provides it to be installed",
        )
    subject = Message(
        "simulated person '{name}' of the package {package_of}",
        name=name,
        package_of=package_of(point),
    )
    kind: object = watched(point, point.load, subject)
    if not (isinstance(kind, type) and issubclass(kind, Behaviour)):
        raise UserError(
            "{subject}: its entry point is {kind}, expected a class derived from Behaviour",
            subject=subject,
            kind=repr(kind),
        )
    return InstalledBehaviour(kind, point)
