"""Select, open and describe a run's sources of finger position and force."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.contact.registry import NONE, open_source
from slipscale.hardware.contact.source import QUANTITIES, ContactSource, Kind, Surroundings
from slipscale.hardware.contact.stage import EMULATED as EMULATED_STAGE
from slipscale.hardware.contact.stage import EmulatedStage

if TYPE_CHECKING:
    from slipscale.experiments.journal.record import Record
    from slipscale.experiments.study.model import Study
    from slipscale.hardware.driver import PlateDriver
    from slipscale.hardware.plate_file import PlateFile

SIMULATED = "simulated"
NEED_A_PARTICIPANT = ("mouse", SIMULATED)
VIRTUAL = (SIMULATED, "scripted", EMULATED_STAGE)
TRIED_S = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactSpecs:
    """SPECs of a run's finger-position and force sources.

    Parameters
    ----------
    position, force : str or None
        SPEC of the source, "none" to use no source, or None if the source is not specified.
    """

    position: str | None = None
    force: str | None = None

    def otherwise(self, other: ContactSpecs) -> ContactSpecs:
        """Return a copy in which unspecified sources are taken from ``other``."""
        return ContactSpecs(
            position=other.position if self.position is None else self.position,
            force=other.force if self.force is None else self.force,
        )

    @property
    def used(self) -> dict[Kind, str]:
        """SPECs of the sources in use, by kind."""
        both: dict[Kind, str | None] = {"position": self.position, "force": self.force}
        return {kind: spec for kind, spec in both.items() if spec and spec != NONE}


NOT_NAMED = ContactSpecs()


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedSource:
    """A finger-position or force source, and its SPEC."""

    spec: str
    source: ContactSource


def of_study(study: Study) -> ContactSpecs:
    """Return the sources specified in a study."""
    return ContactSpecs(position=study.plate.position or None, force=study.plate.force or None)


def of_plate(file: PlateFile | None) -> ContactSpecs:
    """Return the sources specified in a plate file."""
    wiring = file.wiring if file else None
    return ContactSpecs(position=wiring.position, force=wiring.force) if wiring else NOT_NAMED


def of_run(named: ContactSpecs, study: Study, file: PlateFile | None) -> ContactSpecs:
    """Return the sources given by the command, else by the study, else by the plate file."""
    return named.otherwise(of_study(study)).otherwise(of_plate(file))


def simulated(specs: ContactSpecs) -> ContactSpecs:
    """Return the sources for a pilot; a simulated finger replaces all measuring devices."""
    found: dict[Kind, str] = {}
    for kind, spec in specs.used.items():
        name = spec.partition(":")[0]
        found[kind] = spec if name in VIRTUAL else SIMULATED
    return ContactSpecs(position=found.get("position"), force=found.get("force"))


def with_stage(specs: ContactSpecs, study: Study) -> ContactSpecs:
    """Return a pilot's sources; use an emulated stage if the study's strokes are passive."""
    passive = study.stroke is not None and study.stroke.passive
    return (
        replace(specs, position=EMULATED_STAGE)
        if passive and specs.position == SIMULATED
        else (specs)
    )


def of_records(records: list[Record]) -> ContactSpecs:
    """Return the sources used in the most recent session of a run."""
    last = [r.data for r in records if r.kind in ("header", "resume")][-1]
    described = last.get("contact") or {}
    specs = {
        kind: str(described[kind]["spec"]) if kind in described else NONE for kind in QUANTITIES
    }
    return ContactSpecs(position=specs["position"], force=specs["force"])


def open_sources(
    specs: ContactSpecs, surroundings: Surroundings, stack: ExitStack
) -> dict[Kind, NamedSource]:
    """Connect the sources, which stay connected until the exit stack is closed.

    Raises
    ------
    UserError
        If a SPEC is invalid, or its source cannot be used in this run.
    SensorFault
        If a device does not respond.
    """
    opened: dict[Kind, NamedSource] = {}
    for kind, spec in specs.used.items():
        source = stack.enter_context(open_source(kind, spec, surroundings))
        if isinstance(source, EmulatedStage):  # this stage moves the simulated finger
            surroundings = replace(surroundings, finger=source)
        opened[kind] = NamedSource(spec=spec, source=source)
    return opened


def try_sources(specs: ContactSpecs, seed: int) -> list[str]:
    """Connect the sources, read from each of them briefly, and describe each in one sentence."""
    # A pointer requires the window, and a simulated finger requires the simulated participant.
    later = {k: s for k, s in specs.used.items() if s.partition(":")[0] in NEED_A_PARTICIPANT}
    now = ContactSpecs(
        position=NONE if "position" in later else specs.position,
        force=NONE if "force" in later else specs.force,
    )
    clock = SystemClock()
    with ExitStack() as stack:
        opened = open_sources(now, Surroundings(clock=clock, seed=seed), stack)
        for each in opened.values():
            each.source.begin()
        clock.sleep(TRIED_S)
        readings = [f"{kind}: {_readings(each.source)}" for kind, each in opened.items()]
    return [
        *readings,
        *(
            Message("{kind}: {spec} can be tested only during a session", kind=kind, spec=spec)
            for kind, spec in later.items()
        ),
    ]


def _readings(source: ContactSource) -> str:
    """Describe the rate of readings from a source, and the last reading."""
    samples = source.take()
    if not samples:
        return "no finger on the plate"
    pairs = zip(source.quantities, samples[-1].values, strict=True)
    last = ", ".join(f"{name} {value:.3g}" for name, value in pairs)
    return Message(
        "{count:.0f} readings per second; last reading: {last}",
        count=len(samples) / TRIED_S,
        last=last,
    )


def require_virtual(specs: ContactSpecs) -> None:
    """Raise `UserError` unless all sources in a pilot's command can run in virtual time."""
    for kind, spec in specs.used.items():
        if spec.partition(":")[0] not in VIRTUAL:
            raise UserError(
                "--{kind} {spec}: a pilot runs in virtual time; expected {simulated}",
                kind=kind,
                spec=spec,
                simulated=SIMULATED,
            )


def describe_contact(sources: Mapping[Kind, NamedSource], plate: PlateDriver) -> dict[str, object]:
    """Return a description of the sources for the journal; empty if there are no sources."""
    if not sources:
        return {}
    description: dict[str, object] = {
        kind: {"spec": each.spec, **each.source.describe()} for kind, each in sources.items()
    }
    if "position" in sources:
        follows = plate.follow_lag_s is not None
        description["textures"] = "follow the finger" if follows else "for an assumed speed"
        description["texture_lag_s"] = plate.follow_lag_s
    return {"contact": description}
