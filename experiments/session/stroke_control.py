"""Compare strokes with the study's requirements, inform participants, and reject trials.

The outcome of an exploration is written to the journal before the exploration is recorded as done.
Whether a trial is rejected is decided at its end, from the last outcome of each interval. A resumed
session therefore makes the same decision as an uninterrupted session.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from slipscale.experiments.steps.steps import Explore, Feedback
from slipscale.experiments.study.stroke import Stroke, Stroked
from slipscale.hardware.contact.measures import friction, movement

if TYPE_CHECKING:
    from slipscale.experiments.journal.journal import Journal
    from slipscale.experiments.languages.texts import Texts
    from slipscale.experiments.steps.trial import Trial
    from slipscale.hardware.contact.source import Kind, Sample

REASON = "stroke: "


class StrokeControl:
    """Applies a study's requirements for strokes (speed, force and direction) in a session.

    Parameters
    ----------
    stroke : Stroke
    journal : Journal
    texts : Mapping
        Texts in the participant's language, including the advice that is shown if strokes do not
        meet the requirements.
    """

    def __init__(self, stroke: Stroke, journal: Journal, texts: Texts) -> None:
        self._stroke = stroke
        self._journal = journal
        self._texts = texts

    def judged(self, step: Explore, samples: Mapping[Kind, list[Sample]]) -> Feedback | None:
        """Record an exploration's outcome, and return the message for the participant, if any."""
        trial = step.trial
        if step.guide is None or trial is None or not samples:
            return None
        found = measured(samples)
        outside = self._stroke.outside(step.guide, found)
        self._journal.append(
            "stroke",
            task=trial.task,
            trial=trial.number,
            interval=step.interval,
            speed_mm_s=_rounded(found.speed_mm_s),
            normal_n=_rounded(found.normal_n),
            forward_share=_rounded(found.forward_share),
            outside=list(outside),
        )
        if not (outside and self._stroke.feedback_s):
            return None
        text = "\n\n".join(self._texts[f"session.stroke_{each}"] for each in outside)
        return Feedback(text=text, duration_s=self._stroke.feedback_s, trial=trial)

    def rejects(self, trial: Trial) -> str:
        """Return the reason why a finished trial is rejected; empty if it is accepted."""
        last: dict[int | None, list[str]] = {}
        for record in reversed(self._journal.records):
            data = record.data
            if record.kind == "done" and (data["answer"] or {}).get("type") == "Voided":
                break  # earlier records belong to other trials
            if record.kind == "stroke" and (data["task"], data["trial"]) == _key(trial):
                last.setdefault(data["interval"], data["outside"])
        outside = dict.fromkeys(each for own in last.values() for each in own)
        return REASON + ", ".join(outside) if outside and self._stroke.reject else ""

    def repeats(self, trial: Trial) -> bool:
        """Return whether a rejected trial may still be repeated."""
        rejected = {
            record.data["trial"]
            for record in self._journal.records
            if record.kind == "void"
            and record.data["task"] == trial.task
            and record.data["reason"].startswith(REASON)
        }
        ends = [
            record.data["what"]["trial"]
            for record in self._journal.records
            if record.kind == "begin" and record.data["what"]["type"] == "EndTrial"
        ]
        before = {each["number"]: each["repeats"] for each in ends if each["task"] == trial.task}
        count, number = 0, trial.repeats
        while number is not None:
            count, number = count + (number in rejected), before.get(number)
        return count < self._stroke.repeat


def measured(samples: Mapping[Kind, list[Sample]]) -> Stroked:
    """Compute the measures of an exploration that are compared with the requirements."""
    places = samples.get("position", [])
    moved = movement(places)
    return Stroked(
        speed_mm_s=moved.speed_mm_s,
        forward_share=moved.forward_share,
        normal_n=friction(samples["force"], places).normal_n if "force" in samples else None,
    )


def _key(trial: Trial) -> tuple[str, int]:
    return trial.task, trial.number


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)
