"""Test whether headphones are worn and whether noise is heard in both ears.

The test plays 200 Hz tones, of which one is quieter and one is in antiphase (Woods, Siegel, Traer
and McDermott 2017, doi:10.3758/s13414-017-1361-2). With loudspeakers, the antiphase signals cancel
in the air. The test thus detects headphones that are not worn, not plugged in or not selected. The
test by Milne and others (2021, doi:10.3758/s13428-020-01514-0) passes fewer loudspeaker users but
rejects a fifth of the headphone users. The antiphase tone cannot reveal a silent side, so noise is
first played to each ear separately. If a participant fails the test, the operator decides what to
do.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING, Annotated

from pydantic import Field, model_validator

from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.questions.comparison import ComparisonQuestion
from slipscale.experiments.steps.replies import NO_SOUND, Answer, Reply
from slipscale.experiments.steps.steps import Ask, Instruct, Played, Steps
from slipscale.faults.frozen_table import FrozenTable, setting
from slipscale.stimuli.headphone_sounds import EARS, TONES, Ears, NoiseInEar, Tones

if TYPE_CHECKING:
    from slipscale.experiments.languages.texts import Texts
    from slipscale.experiments.protocol_parts.base import Context
    from slipscale.experiments.protocol_parts.simulated_answers import SimulatedAnswer
    from slipscale.experiments.steps.simulated_person import SimulatedPerson
    from slipscale.experiments.steps.trial import Value

HEADPHONES = "headphones"
DECISION, AGAIN, GO_ON = "decision", "again", "go_on"
NOISE, LEVEL, TONE = "noise", "noise_level", "tones"
MOST_TRIALS = 60
LEVELS = ("comfortable", "too_loud", "not_heard")
# Proportion of tones that simulated participants mishear.
MISHEARD = 0.02


class HeadphoneTest(FrozenTable):
    """A test in which a different tone seems quietest with loudspeakers than with headphones."""

    level_db: Annotated[float, Field(strict=True, le=0, ge=-60)] = setting(
        -20.0, "Level of the tones relative to full scale.", unit="dB re full scale"
    )
    trials: Annotated[int, Field(strict=True, ge=1, le=MOST_TRIALS)] = setting(
        6, "Number of trials with three tones each.", unit="trials"
    )
    needed: Annotated[int, Field(strict=True, ge=1, le=MOST_TRIALS)] = setting(
        5, "Number of correct answers needed to pass.", unit="trials"
    )

    @model_validator(mode="after")
    def _passable(self) -> HeadphoneTest:
        if self.needed > self.trials:
            raise ValueError("expected no more than the number of trials")
        return self

    def steps(self, context: Context, texts: Texts, noise: NoiseInEar | None) -> Steps:
        """Yield the steps of the test, which is repeated as often as the operator requests.

        Parameters
        ----------
        context : Context
            Context of the run, which determines the order of the tones.
        texts : Mapping
        noise : NoiseInEar or None
            The study's masking noise for each ear; None if the study uses no noise.
        """
        yield Instruct(title=texts["headphones.title"], text=texts["headphones.instructions"])
        attempt = 0
        while True:
            attempt += 1
            wrong_ears = yield from self._ears(attempt, context, texts, noise)
            right = 0 if wrong_ears is None else (yield from self._tones(attempt, context, texts))
            if wrong_ears is None or right is None:
                return  # no sound output: the journal contains the reason
            if right >= self.needed and not wrong_ears:
                return
            reply = yield self._decision(right, wrong_ears)
            if not isinstance(reply, Reply) or reply.value != AGAIN:
                return
            yield Instruct(text=texts["headphones.again"])

    def _ears(
        self, attempt: int, context: Context, texts: Texts, noise: NoiseInEar | None
    ) -> Generator[Ask, Answer, list[str] | None]:
        """Ask in which ear noise is heard; return the misheard ears (None without sound output)."""
        if noise is None:
            return []
        wrong = []
        options = tuple((code, texts[f"headphones.ear_{code}"]) for code in (*EARS, "none"))
        first = context.stream(HEADPHONES, "ears", attempt).shuffled(["left", "right"])
        for ear in first:
            reply = yield Ask(
                name=f"{NOISE}_{ear}",
                question=ChoiceQuestion(prompt=texts["headphones.which_ear"], options=options),
                task=HEADPHONES,
                played=Played(
                    sound=NoiseInEar(ear=_ear(ear), level_db=noise.level_db, seed=noise.seed),
                    text=texts["headphones.listen"],
                ),
            )
            if isinstance(reply, Reply) and reply.value == NO_SOUND:
                return None
            if isinstance(reply, Reply) and reply.value != ear:
                wrong.append(ear)
        levels = tuple((code, texts[f"headphones.level_{code}"]) for code in LEVELS)
        yield Ask(
            name=LEVEL,
            question=ChoiceQuestion(prompt=texts["headphones.level"], options=levels),
            task=HEADPHONES,
            played=Played(sound=noise, text=texts["headphones.listen"]),
        )
        return wrong

    def _tones(
        self, attempt: int, context: Context, texts: Texts
    ) -> Generator[Ask, Answer, int | None]:
        """Ask for the quietest tones; return the number of correct answers (None without sound)."""
        right = 0
        words = tuple(part.strip() for part in texts["headphones.tones"].split("|"))
        question = ComparisonQuestion(
            prompt=texts["headphones.quietest"], options=words, seeks="least"
        )
        for number in range(1, self.trials + 1):
            order = context.stream(HEADPHONES, attempt, number).shuffled(range(1, TONES + 1))
            tones = Tones(quiet=order[0], antiphase=order[1], level_db=self.level_db)
            reply = yield Ask(
                name=f"{TONE}_{number}",
                question=question,
                task=HEADPHONES,
                played=Played(sound=tones, text=texts["headphones.listen"]),
            )
            if isinstance(reply, Reply) and reply.value == NO_SOUND:
                return None
            right += isinstance(reply, Reply) and reply.value == tones.quiet
        return right

    def _decision(self, right: int, wrong_ears: list[str]) -> Ask:
        """Return the English question that the operator answers about a failed test."""
        ears = f"; the noise in the {' and the '.join(wrong_ears)} ear" if wrong_ears else ""
        elsewhere = " was heard elsewhere" if wrong_ears else ""
        prompt = (
            f"headphone test not passed: {right} of {self.trials} correct, {self.needed} "
            f"needed{ears}{elsewhere}."
        )
        return Ask(
            name=DECISION,
            question=ChoiceQuestion(
                prompt=prompt, options=((GO_ON, "continue anyway"), (AGAIN, "test again"))
            ),
            task=HEADPHONES,
            by="operator",
        )

    def simulated(self) -> dict[tuple[str, str], SimulatedAnswer]:
        """Return functions that simulate the answers of people with headphones."""
        named = [f"{NOISE}_{ear}" for ear in EARS]
        tones = [f"{TONE}_{number}" for number in range(1, self.trials + 1)]
        return {
            **{(HEADPHONES, name): _hears for name in (*named, *tones)},
            (HEADPHONES, LEVEL): lambda _step, _person: LEVELS[0],
            (HEADPHONES, DECISION): lambda _step, _person: GO_ON,
        }


def _ear(name: str) -> Ears:
    return next(ear for ear in EARS if ear == name)


def _hears(step: Ask, person: SimulatedPerson) -> Value:
    """Return the correct answer or, for tones with probability `MISHEARD`, a random answer."""
    sound = step.played.sound if step.played else None
    if isinstance(sound, NoiseInEar):
        return sound.ear
    if not isinstance(sound, Tones):
        return None
    stream = person.stream(step.name, "hears")
    slip = stream.uniform() < MISHEARD
    return float(1 + stream.below(TONES) if slip else sound.quiet)
