"""Control the speed, force and direction of strokes, and respond to deviations.

The rules are:

- a window is a target with a tolerance, such as 80 mm/s ± 30 %; a factor named
  ``finger_speed_mm_s`` or ``normal_force_n`` replaces the target in its conditions;
- the finger's mean speed, mean normal force and direction in an exploration are compared with the
  windows, unless no sensor measures them;
- with ``passive``, a stage moves with the target speed and direction, and only the force is
  compared;
- if an exploration is outside a window and ``reject`` is true, the trial is voided and repeated, at
  most ``repeat`` times.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from slipscale.experiments.protocol_parts.base import Count, Positive, Seconds, Switch
from slipscale.experiments.steps.steps import Explore, Guide, Present, Steps
from slipscale.faults.frozen_table import FrozenTable, setting

if TYPE_CHECKING:
    from slipscale.experiments.languages.texts import Texts
    from slipscale.experiments.steps.replies import Answer
    from slipscale.experiments.steps.trial import Value
    from slipscale.experiments.study.tables import PlateSettings
    from slipscale.faults.validation import Fault

SPEED, FORCE = "finger_speed_mm_s", "normal_force_n"
#: Outcomes, which are used in the keys of the participant's texts and as labels in the data.
WITHIN = "within"
OUTSIDE = ("too_slow", "too_fast", "too_light", "too_hard", "other_direction")
#: Smallest fraction of an exploration's path that must be in the requested direction.
DIRECTION_SHARE = 0.8

Share = Annotated[float, Field(strict=True, gt=0, le=1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Stroked:
    """Measurements of an exploration; values that were not measured are None.

    Parameters
    ----------
    speed_mm_s, normal_n : float or None
        Mean speed and mean normal force.
    forward_share : float or None
        Fraction of the distance along the stroke that is moved towards larger positions.
    """

    speed_mm_s: float | None = None
    normal_n: float | None = None
    forward_share: float | None = None


class Stroke(FrozenTable):
    """Requirements for strokes, and the response to deviations."""

    speed_mm_s: Positive | None = setting(
        None,
        "Required speed of the finger; default: any speed. A factor named "
        "finger_speed_mm_s replaces the required speed.",
    )
    speed_share: Share = setting(
        0.3,
        "Largest accepted deviation of the mean speed, as a fraction of the required speed.",
        unit="share, 0 to 1",
    )
    normal_force_n: Positive | None = setting(
        None,
        "Required normal force of the finger; default: any force. A factor named normal_force_n "
        "replaces the required force.",
        unit="N",
    )
    force_share: Share = setting(
        0.4,
        "Largest accepted deviation of the mean force, as a fraction of the required force.",
        unit="share, 0 to 1",
    )
    direction: Literal["any", "forward", "backward"] = setting(
        "any",
        "Direction of the strokes. forward: towards larger positions of the sensor. In forward "
        "and backward strokes, the finger is lifted between strokes.",
    )
    passive: Switch = setting(
        False,
        "Whether a stage makes the strokes while the finger rests; --position then selects the "
        "stage.",
    )
    pacer: Switch = setting(
        True, "Whether a mark on the participant's screen moves at the required speed."
    )
    stroke_mm: Positive = setting(
        40.0, "Length of a stroke, after which the mark on the screen reverses its direction."
    )
    feedback_s: Seconds = setting(
        1.5,
        "Duration of the text that advises the participant after an exploration outside the "
        "limits; if 0, no text is shown.",
    )
    reject: Switch = setting(
        True,
        "Whether a trial outside the limits is rejected. In either case, a column of the data "
        "states the outcome.",
    )
    repeat: Count = setting(
        2, "Maximum number of times that a rejected trial is repeated.", unit="repetitions"
    )

    def faults(self, plate: PlateSettings) -> Iterator[Fault]:
        """Yield an error for each setting that depends on a missing sensor or setting."""
        position = bool(plate.position)
        if self.passive and not (position and self.speed_mm_s):
            message = "expected speed_mm_s, and a stage as the value of position in [plate]"
            yield ("stroke", "passive"), {"msg": message}
        if self.speed_mm_s and not (position or self.pacer):
            yield ("stroke", "speed_mm_s"), {"msg": "expected position in [plate], or pacer = true"}
        if self.direction != "any" and not position:
            yield ("stroke", "direction"), {"msg": "expected position in [plate]"}
        if self.normal_force_n and not plate.force:
            yield ("stroke", "normal_force_n"), {"msg": "expected force in [plate]"}

    def guide(self, factors: Mapping[str, Value]) -> Guide:
        """Return the instructions for stroking in a condition."""
        return Guide(
            speed_mm_s=_number(factors, SPEED, self.speed_mm_s),
            normal_force_n=_number(factors, FORCE, self.normal_force_n),
            direction=self.direction,
            stroke_mm=self.stroke_mm,
            pacer=self.pacer and not self.passive,
            passive=self.passive,
        )

    def outside(self, guide: Guide, found: Stroked) -> tuple[str, ...]:
        """Return the deviations of an exploration from the requirements (empty if none)."""
        pairs = (
            (
                None if self.passive else found.speed_mm_s,
                guide.speed_mm_s,
                self.speed_share,
                OUTSIDE[:2],
            ),
            (found.normal_n, guide.normal_force_n, self.force_share, OUTSIDE[2:4]),
        )
        advice = [
            less if value < wanted else more
            for value, wanted, share, (less, more) in pairs
            if value is not None and wanted and abs(value - wanted) > share * wanted
        ]
        forward = found.forward_share
        if forward is not None and guide.direction != "any" and not self.passive:
            along = forward if guide.direction == "forward" else 1 - forward
            advice += [OUTSIDE[4]] if along < DIRECTION_SHARE else []
        return tuple(advice)


def guided(steps: Steps, stroke: Stroke, texts: Texts) -> Steps:
    """Yield the steps, with stroke instructions added to explorations."""
    answer: Answer = None
    while True:
        try:
            step = steps.send(answer)
        except StopIteration:
            return
        if isinstance(step, Explore):
            step = _with_guide(step, stroke, texts)
        elif isinstance(step, Present) and step.lead_in:
            present, explore = step.lead_in
            step = replace(step, lead_in=(present, _with_guide(explore, stroke, texts)))
        answer = yield step


def _with_guide(step: Explore, stroke: Stroke, texts: Texts) -> Explore:
    guide = stroke.guide(step.trial.factors if step.trial else {})
    if not stroke.passive:
        return replace(step, guide=guide)
    key = "session.passive_interval" if step.interval else "session.passive"
    return replace(step, guide=guide, text=texts[key].format(number=step.interval))


def _number(factors: Mapping[str, Value], name: str, otherwise: float | None) -> float | None:
    value = factors.get(name)
    return value if isinstance(value, float) else otherwise
