"""A laboratory's own simulated people: a class of its own between Slipscale's person and a task.

Another package names its class by an entry point of the group ``slipscale.participants``; the
entry point's name is a population of ``slipscale pilot --population``. A population file can name
it as well, with other numbers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, NamedTuple, TypeVar

from slipscale.faults import UserError
from slipscale.faults.plug_ins import PARTICIPANTS, installed, package_of
from slipscale.faults.plug_ins import called as watched

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from importlib.metadata import EntryPoint

    from slipscale.experiments.protocols.ordering.randomisation import Stream
    from slipscale.experiments.protocols.simulated_answers import SimulatedPerson
    from slipscale.experiments.protocols.steps import Ask, Explore

T = TypeVar("T")


class Behaviour:
    """A simulated person as a population's numbers make them; derive from it and change a part.

    Whatever is not overridden is what Slipscale's own person does. Random numbers come from
    `stream` alone, so that an interrupted pilot goes on to the same answers.

    Parameters
    ----------
    person : SimulatedPerson
        Slipscale's own.
    """

    #: Keys of a population file, in place of the shipped population's.
    population: ClassVar[Mapping[str, object]] = {}

    def __init__(self, person: SimulatedPerson) -> None:
        self.person = person

    @property
    def language(self) -> str:
        """The language of verbal reports."""
        return self.person.language

    @property
    def scale_top(self) -> float:
        """What this person calls the most slippery surface imaginable."""
        return self.person.scale_top

    @property
    def turned(self) -> int:
        """By how many notches the surface was turned, in an `Adjust`."""
        return self.person.turned

    @property
    def felt_again(self) -> int:
        """How often the reference was felt again, in an `Adjust`."""
        return self.person.felt_again

    @property
    def felt_level(self) -> tuple[float, ...]:
        """What was felt in this trial, µm peak to peak, in the order of its intervals."""
        return self.person.felt_level

    @property
    def impressions(self) -> tuple[float, ...]:
        """How strong each of these seemed, 0 to 100, with the noise of the moment."""
        return self.person.impressions

    def pick(self, strengths: Sequence[float]) -> int:
        """Return the place, from 0, of the strength that is taken for the largest."""
        return self.person.pick(strengths)

    def says_yes(self, strength: float) -> bool:
        """Return whether a difference of impressions is strong enough to say "yes" to."""
        return self.person.says_yes(strength)

    def estimate(self) -> float:
        """Return a magnitude estimate of the surface felt last, on this person's own scale."""
        return self.person.estimate()

    def rating(self, start: float) -> float:
        """Return where on a line of 0 to 100 the surface felt last is put."""
        return self.person.rating(start)

    def ratio(self) -> float:
        """Return how many times as strong as the standard the surface felt last is, above 0."""
        return self.person.ratio()

    def reaches(self, ratio: float) -> bool:
        """Return whether the surface felt last is so many times as strong as the standard."""
        return self.person.reaches(ratio)

    def lapses(self) -> bool:
        """Return whether this person attends to nothing in this question."""
        return self.person.lapses()

    def notices(self) -> bool:
        """Return whether the two surfaces felt last seem different."""
        return self.person.notices()

    def verbal_report(self) -> str:
        """Return what this person says has been removed."""
        return self.person.verbal_report()

    def stream(self, *purpose: str | int) -> Stream:
        """Return random numbers of this person's own for one purpose in this trial."""
        return self.person.stream(*purpose)

    def duration_s(self, step: Explore | Ask, usual_s: float) -> float:  # noqa: ARG002
        """Return how long an exploration or an answer takes, before a study's limits."""
        return usual_s


class InstalledBehaviour(NamedTuple):
    """A class of simulated people, and the entry point that names it."""

    kind: type[Behaviour]
    point: EntryPoint

    @property
    def named(self) -> str:
        """What sentences call it."""
        package = package_of(self.point)
        return f"simulated person '{self.point.name}' of the package {package}"

    def made(self, person: SimulatedPerson) -> Behaviour:
        """Return one of these people."""
        return self.ask(lambda: self.kind(person))

    def ask(self, action: Callable[[], T]) -> T:
        """Return what these people's own code does; what it raises is told in a sentence."""
        return watched(self.point, action, self.named)


def behaviour_names() -> list[str]:
    """Return the names of all installed behaviours, sorted."""
    return list(installed(PARTICIPANTS))


def load_behaviour(name: str) -> InstalledBehaviour:
    """Return an installed behaviour by name.

    Raises
    ------
    UserError
        There is none of that name, it cannot be imported, or it is no `Behaviour`.
    """
    point = installed(PARTICIPANTS).get(name)
    if point is None:
        raise UserError(
            f"simulated person '{name}': no installed package has one of that name; expected "
            f"{' or '.join(behaviour_names()) or 'the package that brings it to be installed'}"
        )
    subject = f"simulated person '{name}' of the package {package_of(point)}"
    kind: object = watched(point, point.load, subject)
    if not (isinstance(kind, type) and issubclass(kind, Behaviour)):
        raise UserError(
            f"{subject}: its entry point is {kind!r}, expected a class derived from Behaviour"
        )
    return InstalledBehaviour(kind, point)
