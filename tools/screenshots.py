"""Write a picture of every screen that a participant can meet, in every language.

Usage: python tools/screenshots.py FOLDER [--language en] [--width 1280 --height 800]
Needs a display; under a virtual one: xvfb-run -s "-screen 0 1280x800x24" ...
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from slipscale.experiments.languages.texts import answers, languages, load_texts
from slipscale.experiments.participants.psychopy_window import scene
from slipscale.experiments.participants.psychopy_window.asking import Stopping
from slipscale.experiments.participants.psychopy_window.display import Display
from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.protocols.building_blocks.repeating import part_over
from slipscale.experiments.protocols.steps import (
    Adjust,
    Ask,
    ChoiceQuestion,
    ComparisonQuestion,
    Explore,
    Feedback,
    Instruct,
    NumberQuestion,
    Reply,
    Rest,
    TextQuestion,
    VisualAnalogueQuestion,
    WholeNumberQuestion,
    YesNoQuestion,
)
from slipscale.experiments.running.pilot import pilot_plans
from slipscale.experiments.running.rehearsal import dry_run
from slipscale.experiments.study.file import read_study, shipped_studies
from slipscale.experiments.study.headphone_test import HeadphoneTest
from slipscale.experiments.study.questionnaires import Item, Questionnaire
from slipscale.hardware.clock import SystemClock
from slipscale.stimuli.headphone_sounds import NoiseInEar

if TYPE_CHECKING:
    from collections.abc import Iterator

    from slipscale.experiments.languages.texts import Texts
    from slipscale.experiments.participants.psychopy_window.scene import Scene
    from slipscale.experiments.participants.psychopy_window.screens import Screen
    from slipscale.experiments.protocols.steps import ParticipantStep

DECIMAL = {"en": "12.5", "fr": "12,5"}
PROMPT = {"en": "Where did you grow up?", "fr": "Où avez-vous grandi ?"}
LONG_LIST = {
    "en": "Albania Austria Belgium Bulgaria Croatia Cyprus Czechia Denmark Estonia Finland France "
    "Germany Greece Hungary Ireland Italy Latvia Lithuania Luxembourg Malta Elsewhere",
    "fr": "Albanie Allemagne Autriche Belgique Bulgarie Chypre Croatie Danemark Espagne Estonie "
    "Finlande France Grèce Hongrie Irlande Italie Lettonie Lituanie Luxembourg Malte Ailleurs",
}
LONG_TEXT = {
    "en": "It seems less sticky than before, as if a thin film had been wiped off the glass",
    "fr": "C'est moins collant qu'avant, comme si l'on avait ôté une fine pellicule de la plaque",
}


def typed(screen: Screen, characters: str) -> Screen:
    """Return the screen after some typing."""
    for character in characters:
        screen.press(character, 1.0)
    return screen


def scenes(language: str, texts: Texts) -> dict[str, Scene]:
    """Return every screen by a name, as it looks 3.4 s after it came up."""
    number = Ask(
        name="estimate", question=NumberQuestion(prompt=texts["magnitude_estimation.estimate"])
    )
    yes_no = Ask(
        name="difference",
        question=YesNoQuestion(prompt=texts["descending_difference.difference"]),
    )
    words = texts["descending_difference.confidence_options"].split(" | ")
    choice = Ask(
        name="confidence",
        question=ChoiceQuestion(
            prompt=texts["descending_difference.confidence"],
            options=tuple((str(n), word) for n, word in enumerate(words)),
        ),
        time_limit_s=10.0,
    )
    text = Ask(
        name="verbal_report",
        question=TextQuestion(prompt=texts["descending_difference.verbal_report"]),
    )
    consent = Ask(
        name="informed_consent",
        question=ChoiceQuestion(
            prompt=texts["session.consent_question"],
            options=tuple((code, texts[f"session.consent_{code}"]) for code in ("yes", "no")),
        ),
    )
    age = Ask(
        name="age_years",
        question=WholeNumberQuestion(prompt=texts["about_you.age_years"], minimum=18, maximum=99),
    )
    three = Ask(
        name="response",
        question=ComparisonQuestion(
            prompt=texts["difference_threshold.more.question"],
            options=tuple(answers(texts["comparing.options"])),
        ),
        time_limit_s=10.0,
    )
    line = Ask(
        name="rating",
        question=VisualAnalogueQuestion(
            prompt=texts["visual_analogue_scale.rating"],
            left=texts["visual_analogue_scale.left"],
            right=texts["visual_analogue_scale.right"],
            resolution=1.0,
            key_step=1.0,
            start=50.0,
            start_shown=False,
        ),
        time_limit_s=10.0,
    )
    about_you = read_study("biet2007")[0].about_you
    stroke = texts["magnitude_estimation.explore"]
    pages: dict[str, ParticipantStep] = {
        "welcome": Instruct(title=texts["session.welcome_title"], text=texts["session.welcome"]),
        "consent": Instruct(title=texts["session.consent_title"], text=texts["session.consent"]),
        "consent-question": consent,
        "consent-missing": Instruct(text=texts["session.consent_missing"]),
        **{f"about-{each.name}": each.ask(language, texts) for each in about_you},
        "instructions": Instruct(
            title=texts["magnitude_estimation.title"],
            text=texts["magnitude_estimation.instructions"],
        ),
        "instructions-standard": Instruct(
            title=texts["magnitude_estimation.title"],
            text=texts["magnitude_estimation.instructions_standard"].format(modulus=10, twice=20),
        ),
        "practice": Instruct(text=texts["magnitude_estimation.practice"]),
        "explore": Explore(text=stroke),
        "explore-minimum": Explore(text=stroke, minimum_s=5.0, maximum_s=10.0),
        "rest": Rest(text=texts["session.rest"], done=12, total=28),
        "rest-minimum": Rest(text=texts["session.rest"], done=12, total=28, minimum_s=30.0),
        "part-over": part_over(texts),
        "thanks": Instruct(
            title=texts["session.thanks_title"], text=texts["session.thanks"], last=True
        ),
    }
    screens = {name: screen_for(step, texts) for name, step in pages.items()} | {
        "number": typed(screen_for(number, texts), DECIMAL[language]),
        "number-empty": screen_for(number, texts),
        "number-longest": typed(screen_for(number, texts), "12345678901234567890"),
        "number-refused": typed(screen_for(number, texts), "12 ou 13\r"),
        "number-ambiguous": typed(screen_for(number, texts), "1,000\r"),
        "age-refused": typed(screen_for(age, texts), "17\r"),
        "yes-no": screen_for(yes_no, texts),
        "yes-no-refused": typed(screen_for(yes_no, texts), "x"),
        "choice": screen_for(choice, texts),
        "comparison-of-three": screen_for(three, texts),
        "text": typed(screen_for(text, texts), LONG_TEXT[language]),
        "text-full": typed(screen_for(text, texts), (LONG_TEXT[language] + ". ") * 4),
        "stop": Stopping(texts),
    }
    touched = {**texts, "window.touch": "yes"}
    countries = tuple((word, word) for word in LONG_LIST[language].split())
    country = Ask(
        name="country", question=ChoiceQuestion(prompt=PROMPT[language], options=countries)
    )
    moved = screen_for(country, texts)
    moved.move(-13)
    screens |= {
        "list": screen_for(country, texts),
        "list-moved": moved,
        "list-refused": typed(screen_for(country, texts), "99\r"),
        "touch-number": typed(screen_for(number, touched), DECIMAL[language]),
        "touch-number-refused": typed(screen_for(number, touched), "..\r"),
        "touch-yes-no": screen_for(yes_no, touched),
        "touch-choice": screen_for(choice, touched),
        "touch-list": typed(screen_for(country, touched), "7"),
        "touch-explore": screen_for(pages["explore"], touched),
        "touch-rest": screen_for(pages["rest"], touched),
        "spoken": screen_for(replace(number, by="operator", time_limit_s=20.0), texts),
        "touch-welcome": screen_for(pages["welcome"], touched),
    }
    screens |= {
        f"asked-{number:02d}-{type(step).__name__.lower()}": screen_for(step, texts)
        for number, step in enumerate(asked_beside(language, texts), start=1)
    }
    screens["line-refused"] = typed(screen_for(line, texts), " ")
    screens["line"] = screen_for(line, texts)
    screens["line"].move(13)
    return {name: screen.scene(3.4) for name, screen in screens.items()} | {
        "hold": scene.message(texts["session.hold"]),
        "release": scene.message(texts["window.release_keys"]),
        "focus": scene.message(texts["window.focus"]),
    }


ASKED = Questionnaire(
    name="habits",
    description="Made up for pictures",
    title={"en": "Your habits", "fr": "Vos habitudes"},
    instructions={
        "en": "How far do you agree with what follows?\n\nThere are no right or wrong answers.",
        "fr": "Êtes-vous d'accord avec ce qui suit ?\n\nIl n'y a ni bonne ni mauvaise réponse.",
    },
    options={
        "1": {"en": "not at all", "fr": "pas du tout d'accord"},
        "2": {"en": "rather not", "fr": "plutôt pas d'accord"},
        "3": {"en": "neither", "fr": "ni l'un ni l'autre"},
        "4": {"en": "rather", "fr": "plutôt d'accord"},
        "5": {"en": "fully", "fr": "tout à fait d'accord"},
    },
    items=(
        Item(
            name="h01",
            prompt={
                "en": "In a shop I touch things that I do not mean to buy.",
                "fr": "Dans un magasin, je touche des objets que je ne veux pas acheter.",
            },
        ),
    ),
)


def asked_beside(language: str, texts: Texts) -> Iterator[Instruct | Ask | Feedback]:
    """Yield what is asked beside trials: a questionnaire, and the headphone test once failed."""
    noise = NoiseInEar(ear="both", level_db=-20.0, seed=1)
    test = HeadphoneTest(trials=1, needed=1)
    plan = pilot_plans("biet2007", participants=1, seed=None, language=language)[0]
    answer = Reply(value="left")
    for steps in (ASKED.steps(language, texts), test.steps(plan.context(), texts, noise)):
        step = next(steps)
        while True:
            if isinstance(step, Ask) and step.played:
                yield Feedback(text=step.played.text, duration_s=10.0)
            if isinstance(step, Instruct | Ask):
                yield step
            decided = isinstance(step, Ask) and step.by == "operator"
            try:
                step = steps.send(Reply(value="go_on") if decided else answer)
            except StopIteration:
                break


def of_studies(language: str) -> dict[str, Scene]:
    """Return every further screen of the shipped studies: each instruction, question, turning."""
    found: dict[str, Scene] = {}
    seen: set[tuple[str, ...]] = set()
    for study in shipped_studies():
        plan = pilot_plans(study, participants=1, seed=None, language=language)[0]
        for step in dry_run(plan):
            if not isinstance(step, Instruct | Explore | Ask | Adjust | Feedback):
                continue
            words = step.question.prompt if isinstance(step, Ask) else step.text
            if (type(step).__name__, words) in seen:
                continue
            seen.add((type(step).__name__, words))
            name = f"{study}-{len(found) + 1:02d}-{type(step).__name__.lower()}"
            found[name] = screen_for(step, plan.texts()).scene(3.4)
    return found


def main() -> int:
    """Draw all scenes and save them; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--language", choices=languages(), action="append")
    parser.add_argument("--only", help="one screen's name")
    parser.add_argument("--pilot", action="store_true", help="with the pilot run's banner")
    parser.add_argument("--width", type=int, default=1280)
    parser.add_argument("--height", type=int, default=800)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    size = (options.width, options.height)
    with Display(SystemClock(), full_screen=False, screen=0, size=size) as display:
        for language in options.language or languages():
            texts = load_texts(language)
            banner = scene.pilot_banner(texts["window.pilot"]) if options.pilot else ()
            for name, shown in (scenes(language, texts) | of_studies(language)).items():
                if options.only in (None, name):
                    display.draw((*shown, *banner))
                    display.save(options.folder / f"{name}-{language}.png")
                    display.flip()
    return 0


if __name__ == "__main__":
    sys.exit(main())
