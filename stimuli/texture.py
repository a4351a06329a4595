"""Define gratings: surfaces whose friction varies periodically.

Spatial variation in slipperiness is perceived as relief (see the introduction and conclusion of the
paper). The amplitude of a grating is a function of position. For a known finger speed, the grating
is converted to a sequence of commands that the plate and its serial line can follow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, NoReturn, get_args

from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.stimuli.modulation import (
    DEFAULT_MODULATOR,
    STEPS_MAX,
    AmplitudeStep,
    Followed,
    Loop,
    Modulator,
)
from slipscale.stimuli.parameters import FINGER_SPEED, Parameter, Parametric
from slipscale.stimuli.surface import Sensor
from slipscale.stimuli.waves import HALF, HARMONICS, WAVES, Harmonic, Waveform, added, ends_of

# Largest displacement of an edge of a played square wave, as a fraction of the period.
_EDGE_SHARE = 0.01


def _share(order: str) -> Parameter:
    return Parameter(
        name=f"{order} harmonic",
        unit="share",
        least=0,
        most=1,
        description="Depth of the harmonic, as a fraction of the sine's depth; default: 0.",
    )


def _phase(what: str, description: str) -> Parameter:
    return Parameter(name=what, unit="°", least=0, most=360, description=description)


def _harmonic_phase(order: str) -> Parameter:
    return _phase(
        f"{order} harmonic phase",
        "Phase of the harmonic at the beginning of a period of the sine.",
    )


# Longer than any plate.
LONGEST_MM = 1000.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Grating(Parametric):
    """Periodic variation in friction, either along the stroke of the finger or in time.

    Either ``spatial_period_mm`` or ``modulation_hz`` must be given. If ``modulation_hz`` is given,
    the variation does not depend on the finger's speed. Each `Parameter` can be the level of a
    study.

    Parameters
    ----------
    waveform : {"sine", "square", "triangle", "sawtooth"}
        Shape of the amplitude over a period.
    label : str
        Code that does not reveal which texture is presented.
    name : str
        Name of the texture in the study and in the data.

    Raises
    ------
    UserError
        If a parameter is out of range, or if the waveform is unknown.
    """

    #: Key by which a record is identified as a grating.
    MARK: ClassVar = "waveform"

    spatial_period_mm: Annotated[
        float | None,
        Parameter(
            name="spatial period",
            unit="mm",
            above=0,
            most=LONGEST_MM,
            description="Length of one period.",
        ),
    ] = None
    mean_level: Annotated[
        float,
        Parameter(
            name="mean {q.name}",
            unit=None,
            least=0,
            description="Midpoint between the lowest and the highest vibration amplitude.",
        ),
    ]
    depth_level: Annotated[
        float,
        Parameter(
            name="depth",
            unit=None,
            least=0,
            description=(
                "Amplitude of the modulation: the vibration amplitude varies from mean - "
                "depth to mean + depth."
            ),
        ),
    ]
    waveform: Waveform = "sine"
    label: str = ""
    name: str = ""
    finger_speed_mm_s: Annotated[float, FINGER_SPEED] = 50.0
    modulation_hz: Annotated[
        float | None,
        Parameter(
            name="modulation frequency",
            unit="Hz",
            above=0,
            description="Periods per second, used instead of a spatial period; it does not depend "
            "on "
            "finger speed.",
        ),
    ] = None
    duty_share: Annotated[
        float,
        Parameter(
            name="duty cycle",
            unit="share",
            above=0,
            most=0.99,
            description="Fraction of a square wave's period with the larger amplitude.",
        ),
    ] = 0.5
    phase_deg: Annotated[float, _phase("phase", "Phase at which the wave begins.")] = 0.0
    second_harmonic_share: Annotated[float, _share("second")] = 0.0
    second_harmonic_phase_deg: Annotated[float, _harmonic_phase("second")] = 0.0
    third_harmonic_share: Annotated[float, _share("third")] = 0.0
    third_harmonic_phase_deg: Annotated[float, _harmonic_phase("third")] = 0.0
    fourth_harmonic_share: Annotated[float, _share("fourth")] = 0.0
    fourth_harmonic_phase_deg: Annotated[float, _harmonic_phase("fourth")] = 0.0
    fifth_harmonic_share: Annotated[float, _share("fifth")] = 0.0
    fifth_harmonic_phase_deg: Annotated[float, _harmonic_phase("fifth")] = 0.0
    sixth_harmonic_share: Annotated[float, _share("sixth")] = 0.0
    sixth_harmonic_phase_deg: Annotated[float, _harmonic_phase("sixth")] = 0.0
    seventh_harmonic_share: Annotated[float, _share("seventh")] = 0.0
    seventh_harmonic_phase_deg: Annotated[float, _harmonic_phase("seventh")] = 0.0
    eighth_harmonic_share: Annotated[float, _share("eighth")] = 0.0
    eighth_harmonic_phase_deg: Annotated[float, _harmonic_phase("eighth")] = 0.0

    def __post_init__(self) -> None:
        self.refuse_parameters()
        if (self.spatial_period_mm is None) == (self.modulation_hz is None):
            raise UserError(
                "{where}: expected either spatial_period_mm or modulation_hz", where=self.where
            )
        if self.waveform not in WAVES:
            known = ", ".join(get_args(Waveform))
            raise UserError(
                "{where}: unknown waveform '{waveform}' (expected one of: {known})",
                where=self.where,
                waveform=self.waveform,
                known=known,
            )
        if self.duty_share != HALF and self.waveform != "square":
            raise UserError(
                "{where}: duty_share is {duty_share}, which requires a square wave, but waveform "
                "is '{waveform}'",
                where=self.where,
                duty_share=self.duty_share,
                waveform=self.waveform,
            )
        for name in HARMONICS:
            share, phase = f"{name}_harmonic_share", f"{name}_harmonic_phase_deg"
            if getattr(self, phase) and not getattr(self, share):
                raise UserError(
                    "{where}: {phase} is {value}, but {share} is 0; expected {share} above 0",
                    where=self.where,
                    phase=phase,
                    value=getattr(self, phase),
                    share=share,
                )
        if self._harmonics and self.waveform != "sine":
            raise UserError(
                "{where}: only a sine can have harmonics, but waveform is '{waveform}'",
                where=self.where,
                waveform=self.waveform,
            )
        if self.depth_level > (most := self.mean_level / -self._ends[0]):
            of = "the mean, " if most == self.mean_level else ""
            raise UserError(
                "{where}: depth must be at most {of}{most:.6g}, but is {depth_level}",
                where=self.where,
                of=of,
                most=most,
                depth_level=self.depth_level,
            )

    @property
    def _harmonics(self) -> tuple[Harmonic, ...]:
        """Harmonics with a depth above 0."""
        every = (
            Harmonic(
                order,
                getattr(self, f"{name}_harmonic_share"),
                getattr(self, f"{name}_harmonic_phase_deg") / 360,
            )
            for name, order in HARMONICS.items()
        )
        return tuple(each for each in every if each.share)

    @property
    def _ends(self) -> tuple[float, float]:
        """Smallest and largest value of the wave."""
        return ends_of(self._harmonics)

    @property
    def _highest_order(self) -> int:
        """Order of the highest harmonic; 1 without harmonics."""
        return max((each.order for each in self._harmonics), default=1)

    @property
    def level(self) -> float:
        """Largest amplitude in µm peak to peak."""
        return self.mean_level + self.depth_level * self._ends[1]

    @property
    def lowest_level(self) -> float:
        """Smallest amplitude in µm peak to peak."""
        return self.mean_level + self.depth_level * self._ends[0]

    @property
    def settled_level(self) -> float:
        """Level at which the plate settles before the wave is played (mean of the wave)."""
        return self.mean_level + self.depth_level * (2 * self.duty_share - 1)

    @property
    def needs_sensor(self) -> bool:
        """Always False, because a finger speed is assumed if there is no sensor."""
        return False

    @property
    def sensor(self) -> Sensor | None:
        """Sensor that can control the amplitude, or None for a grating that varies in time."""
        return "position" if self.spatial_period_mm and self.depth_level else None

    @property
    def summary(self) -> str:
        """Description of the waveform, amplitudes, period and finger speed."""
        return (
            f"{self.waveform}, {self.lowest_level:.4g} to {self.level:.4g}, period {self.caption}, "
            f"for a finger at {self.finger_speed_mm_s:g} mm/s"
        )

    def shown(self, share: float) -> float:
        """Return the amplitude in a drawing of three periods, at a position from 0 to 1."""
        return self.level_in(3 * share)

    def level_at(self, position_mm: float, _across_mm: float = 0.0) -> float:
        """Return the amplitude at a position along the stroke."""
        if self.spatial_period_mm is None:
            raise ValueError(
                Message("{where} varies only in time and has no position", where=self.where)
            )
        return self.level_in(position_mm / self.spatial_period_mm)

    def level_in(self, periods: float) -> float:
        """Return the amplitude after a number of periods."""
        phase = (periods + self.phase_deg / 360) % 1.0
        if self.duty_share != HALF:
            # A square wave is high for phases below one half, whereas this wave is high below
            # `duty_share`.
            phase = 0.0 if phase < self.duty_share else HALF
        wave = WAVES[self.waveform].value(phase) + added(phase, self._harmonics)
        return self.mean_level + self.depth_level * wave

    @property
    def caption(self) -> str:
        """Spatial period in mm or, if the grating varies in time, frequency in Hz, as text."""
        if self.spatial_period_mm is None:
            return f"{self.modulation_hz:g} Hz"
        return f"{self.spatial_period_mm:g} mm"

    def rate_hz(self, finger_speed_mm_s: float) -> float:
        """Return the number of periods per second for a finger with the given speed."""
        if self.spatial_period_mm is None:
            return self.modulation_hz or 0.0
        return abs(finger_speed_mm_s) / self.spatial_period_mm

    def followed(self, modulator: Modulator = DEFAULT_MODULATOR) -> Followed | None:
        """Predict how well amplitude and friction follow the grating's highest harmonic.

        Return None if the depth is zero.
        """
        if self.depth_level == 0:
            return None
        rate_hz = self._highest_order * self.rate_hz(self.finger_speed_mm_s)
        return Followed(
            change=f"{rate_hz:.3g} Hz at {self.finger_speed_mm_s:g} mm/s",
            whole="a sinusoidal depth",
            plate=modulator.passed(rate_hz),
            friction=modulator.friction_passed(rate_hz),
            remedy="a longer period, or a slower finger",
        )

    @property
    def _fewest_steps(self) -> int:
        """Smallest number of equal steps per period with which the wave can be represented."""
        edges = (self.phase_deg / 360, self.duty_share)
        fewest = WAVES[self.waveform].steps_min * self._highest_order
        if self.waveform != "square":
            return fewest
        return next(
            (
                steps
                for steps in range(fewest, STEPS_MAX)
                if all(abs(e * steps - round(e * steps)) <= _EDGE_SHARE * steps for e in edges)
            ),
            STEPS_MAX,
        )

    def envelope(
        self, finger_speed_mm_s: float, duration_s: float, modulator: Modulator = DEFAULT_MODULATOR
    ) -> tuple[AmplitudeStep, ...]:
        """Return the commands for a finger that moves at constant speed.

        Parameters
        ----------
        finger_speed_mm_s : float
            Speed of the finger, negative for backward movement. The stroke starts at position 0.
        duration_s : float
            Duration of the stroke.
        modulator : Modulator
            Limits of the plate's resonance and of the serial line.

        Returns
        -------
        tuple of AmplitudeStep
            Commands in chronological order, starting at time 0. The amplitude of each step is the
            value of the wave in the middle of the step.

        Raises
        ------
        UserError
            If the finger crosses the grating faster than the plate or serial line can follow.
        """
        if not math.isfinite(finger_speed_mm_s):
            raise UserError(
                "{where}: finger_speed_mm_s is {finger_speed_mm_s}, expected a finite number of "
                "mm/s",
                where=self.where,
                finger_speed_mm_s=finger_speed_mm_s,
            )
        if not (math.isfinite(duration_s) and duration_s > 0):
            raise UserError(
                "{where}: duration_s is {duration_s}, expected above 0 s",
                where=self.where,
                duration_s=duration_s,
            )
        rate = self.rate_hz(finger_speed_mm_s)
        if rate == 0 or self.depth_level == 0:
            return (AmplitudeStep(0.0, self.level_in(0.0)),)
        fewest = self._fewest_steps
        fastest = modulator.fastest_hz(fewest)
        if rate > fastest:
            self._refuse_rate(abs(finger_speed_mm_s), rate, fastest)
        most = min(1 / (rate * modulator.shortest_step_s) + 1e-9, STEPS_MAX)
        steps = fewest if self.waveform == "square" else math.floor(most)
        step_s = 1 / (rate * steps)
        count = math.ceil(duration_s / step_s - 1e-9)
        pace = finger_speed_mm_s
        place = self.level_in if self.spatial_period_mm is None else self.level_at
        if self.spatial_period_mm is None:
            pace = rate
        return tuple(
            AmplitudeStep(i * step_s, place((i + 0.5) * step_s * pace)) for i in range(count)
        )

    def _refuse_rate(self, speed_mm_s: float, rate_hz: float, fastest_hz: float) -> NoReturn:
        """Raise the error for a wave that is too fast for the plate or the serial line."""
        if self.spatial_period_mm is None:
            raise UserError(
                "{where}: modulation_hz is {rate_hz:.3g}, but the plate and its connection can "
                "follow at most {fastest_hz:.3g} Hz",
                where=self.where,
                rate_hz=rate_hz,
                fastest_hz=fastest_hz,
            )
        raise UserError(
            "{where}: a finger at {speed_mm_s:g} mm/s crosses {rate_hz:.3g} periods per second, "
            "but the plate and its connection can follow at most {fastest_hz:.3g}: expected a "
            "finger speed up to {fastest_mm_s:.3g} mm/s or a period from {shortest_mm:.3g} mm",
            where=self.where,
            speed_mm_s=speed_mm_s,
            rate_hz=rate_hz,
            fastest_hz=fastest_hz,
            fastest_mm_s=fastest_hz * self.spatial_period_mm,
            shortest_mm=speed_mm_s / fastest_hz,
        )

    def change(
        self,
        modulator: Modulator = DEFAULT_MODULATOR,  # noqa: ARG002 - on any plate
    ) -> Loop | None:
        """Return None, because nothing is triggered."""
        return None

    def loop(self, modulator: Modulator = DEFAULT_MODULATOR) -> Loop | None:
        """Return one period of the grating at the assumed finger speed; None if the depth is zero.

        Raises
        ------
        UserError
            If the finger crosses the grating faster than the plate or serial line can follow.
        """
        if self.depth_level == 0:
            return None
        period_s = 1 / self.rate_hz(self.finger_speed_mm_s)
        steps = self.envelope(self.finger_speed_mm_s, period_s, modulator)
        step_s = period_s / len(steps)
        return Loop(
            levels=tuple(step.level for step in steps),
            step_s=step_s,
            edge_s=min(modulator.edge_s, step_s),  # rounding errors can make step_s the shorter one
            # The mean is computed from the steps, which can displace the edges of a square wave.
            mean_level=self.mean_level
            if self.duty_share == HALF
            else sum(step.level for step in steps) / len(steps),
        )


def bar(
    name: str,
    *,
    label: str,
    centre_mm: float,
    width_mm: float,
    on_level: float,
    off_level: float,
    period_mm: float,
) -> Grating:
    """Return a grating with one level on a bar across the stroke and another level elsewhere.

    Parameters
    ----------
    name, label : str
        See `Grating`.
    centre_mm, width_mm : float
        Position of the bar's centre and width of the bar, measured along the stroke.
    on_level, off_level : float
        Level on the bar, and level outside the bar.
    period_mm : float
        Distance between successive bars, long enough for the finger not to reach the next bar.
    """
    share = width_mm / period_mm
    high_mm = centre_mm + (-width_mm if on_level > off_level else width_mm) / 2
    return Grating(
        label=label,
        name=name,
        waveform="square",
        spatial_period_mm=period_mm,
        mean_level=(on_level + off_level) / 2,
        depth_level=abs(on_level - off_level) / 2,
        duty_share=round(share if on_level > off_level else 1 - share, 9),
        phase_deg=round(-high_mm / period_mm % 1 * 360, 9),
    )
