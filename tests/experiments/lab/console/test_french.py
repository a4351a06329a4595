"""A French page shows no English sentence, and a further language is one file."""

import re
from string import Formatter
from typing import get_args

import pytest

from slipscale.experiments.lab.console import page_texts
from slipscale.experiments.lab.console.actions import sessions
from slipscale.experiments.lab.console.page_texts import ENGLISH, Words, catalogue, languages
from slipscale.experiments.lab.folder import LabFile
from slipscale.experiments.study.schema import study_schema
from slipscale.faults.message import Message
from slipscale.faults.validation import OTHER, SENTENCES, complaint, sentences
from slipscale.hardware.conformance import contract, table
from slipscale.hardware.errors import FAULTS, PlateFault
from tests.experiments.lab.console.spoken import Sentences, reached_from, text_of

CONSOLE = "slipscale.experiments.lab.console"
COMMANDS = (
    *(f"slipscale.experiments.cli.{name}" for name in ("sessions", "lab", "data", "plate")),
    *(
        f"slipscale.analysis.cli.{name}"
        for name in ("analyse", "export", "power", "study", "pilot")
    ),
)
# Modules of which pages show more than the errors.
SHOWN = tuple(
    f"slipscale.experiments.{name}"
    for name in (
        *(f"lab.console.{each}" for each in ("actions", "notices", "jobs", "presence", "state")),
        *(f"dataset.{each}" for each in ("verification", "former_tables", "withdrawn")),
        *(
            "study.run_plan",
            "running.preflight",
            "session.interruptions",
            "session.operator_answers",
        ),
        "participants.psychopy_window.layout",
    )
)
# Parts of commands that the console does not use: several tables, plans for many
# studies, the design of plates, emulated and guided boards, and PsychoPy's own programs.
UNUSED = tuple(
    f"slipscale.{name}"
    for name in (
        # The console describes one table at a time, and writes its options itself.
        *("analysis.reading.foreign.names", "analysis.reading.meaning."),
        *("analysis.statistics.", "analysis.planning.distribution."),
        *("analysis.planning.protocols.", "analysis.cli.pilot_times", "stimuli.film.periodic_film"),
        *("analysis.cli.compare_protocols", "hardware.plate.", "hardware.cli.design"),
        "hardware.backends.daq_device",
        *("hardware.emulator.", "hardware.conformance.guided", "experiments.psychopy_builder"),
    )
)
OTHERS = [code for code in languages() if code != ENGLISH]
# Options, commands, types and units, which the collection of texts also finds.
NO_MESSAGE = {
    *(
        "--force daq",
        "--force simulated",
        "--force ati",
        "--position mouse",
        "--position simulated",
    ),
    *("dict[str, object]", "slipscale data build {}", "µm peakroughness_um{}", "µm peakµm{}"),
    "import pandas; pandas.",
}


def options():
    """Return the options of commands that the console, or a folder's settings, can give."""
    used = (text_of(name) for name in reached_from([f"{CONSOLE}.app"]) if CONSOLE in name)
    given = {option for text in used for option in re.findall(r'"(--[a-z-]+)"', text)}
    return given | {f"--{key.replace('_', '-')}" for key in LabFile.model_fields} | {"--{}"}


def possible(sentence, given):
    """Return whether a sentence is about an option that the console gives, if about any."""
    option = re.match(r"--[\w{}-]+", sentence)
    return not option or option[0] in given


def shown_sentences():
    given, names = options(), reached_from([f"{CONSOLE}.app", f"{CONSOLE}.serve", *COMMANDS])
    for name in names:
        if not name.startswith(UNUSED):
            found = Sentences(name, everything=name.startswith(SHOWN)).found
            yield from (each for each in found if possible(each, given))
    yield from (kind.remedy for kind in (PlateFault, *FAULTS.values()))
    yield from (kind.in_general for kind in (PlateFault, *FAULTS.values()))
    asked = get_args(sessions.Ask.model_fields["what"].annotation)
    yield from (what.replace("_", " ") for what in asked)
    yield from (*SENTENCES.values(), OTHER)
    yield from (rule for rule, _ in (*table.RULES, *contract.RULES))


@pytest.mark.parametrize("language", OTHERS)
def test_every_template_that_a_page_can_show_is_in_every_catalogue(language):
    known = {each.removeprefix("; ") for each in catalogue(language).messages}
    assert set(shown_sentences()) - known == NO_MESSAGE


@pytest.mark.parametrize("language", OTHERS)
def test_every_key_of_a_study_is_described_in_every_catalogue(language):
    def described(schema):
        tables = schema.values() if isinstance(schema, dict) else schema
        for key in ("description", "unit") if isinstance(schema, dict) else ():
            if isinstance(schema.get(key), str):
                yield schema[key].removeprefix("none")
        for inner in tables if isinstance(schema, dict | list) else ():
            yield from described(inner)

    schema = study_schema()
    wanted = {each for part in (schema["properties"], schema["$defs"]) for each in described(part)}
    symbols = {each for each in wanted if not re.search("[a-z]{3}", each)}
    assert wanted - set(catalogue(language).messages) == symbols


def fields(template):
    return {name for _, name, _, _ in Formatter().parse(template) if name is not None}


@pytest.mark.parametrize("language", OTHERS)
def test_a_translation_has_the_placeholders_of_its_template(language):
    for english, translated in catalogue(language).messages.items():
        if "{" in english:
            assert fields(translated) == fields(english), english


@pytest.fixture
def with_german(tmp_path_factory, monkeypatch):
    """Add a third language, as one file."""
    folder = tmp_path_factory.mktemp("catalogues")
    for source in page_texts.CATALOGUES.iterdir():
        (folder / source.name).write_text(source.read_text(encoding="utf-8"), encoding="utf-8")
    (folder / "de.toml").write_text(
        """
        [page]
        language = "Deutsch"
        today = "Heute"
        [messages]
        "participant {label} is no longer next; check the table again" = "{label} ist nicht dran"
        """
    )
    monkeypatch.setattr(page_texts, "CATALOGUES", folder)
    caches = (page_texts.languages, page_texts.catalogue)
    for each in caches:
        each.cache_clear()
    yield
    for each in caches:
        each.cache_clear()


def test_a_third_language_is_one_file(with_german, visitor, recorded):
    page = visitor.see("/?lang=de")
    assert '<html lang="de">' in page
    assert "Heute" in page
    assert 'hreflang="fr">Français</a>' in page
    assert "planned participants have started" in page  # what is missing is English
    said = Message("participant {label} is no longer next; check the table again", label="03")
    assert Words("de").say(said) == "03 ist nicht dran"


def test_a_french_page_answers_in_french(visitor, recorded):
    visitor.client.cookies.set("lang", "fr")
    assert visitor.ask("unblind", word="voir") == (
        200,
        "noté\N{NBSP}: les résultats sont visibles désormais",
    )
    asked = {"participant": "01", "excluded": True, "reason": "gants"}
    said = visitor.ask("exclude", **asked)[1]
    assert said == "le participant 01 est exclu\N{NBSP}; la prochaine analyse en tient compte"
    assert "glissance" in visitor.see("/study")
    assert visitor.ask("resume", participant="09", session="", run="01") == (
        409,
        (
            "le passage demandé du participant 09 n’est pas interrompu\N{NBSP}; regardez à nouveau "
            "le tableau"
        ),
    )


def test_an_error_with_several_faults_is_translated_with_all_of_them():
    faults = [
        (("seed",), {"type": "greater_than_equal", "ctx": {"ge": 0}, "input": -7}),
        ((), {"type": "missing"}),
    ]
    error = complaint("a.toml", sentences(faults, {("seed",): 3, (): 4}.get))
    assert str(error) == (
        "a.toml has 2 faults:\n  line 3, seed: expected 0 or more, got -7\n  line 4, is missing"
    )
    assert Words("fr").say(str(error)).replace("\N{NBSP}", " ") == (
        "a.toml : 2 erreurs :\n"
        "  ligne 3, seed : 0 ou plus est attendu ; reçu : -7\n"
        "  ligne 4, manque"
    )


def test_an_operator_s_own_words_are_not_translated():
    words = "glove: changed; it is torn"
    assert Words("fr").say(words) == words
    assert Words("fr").say("the glove is missing") == "the glove is missing"


def test_a_plate_s_error_is_french(visitor, lab):
    text = (lab / "slipscale.toml").read_text()
    changed = re.sub("(?m)^plate = .*", 'plate = "serial:/dev/ttyACM9,plate=none.toml"', text)
    (lab / "slipscale.toml").write_text(changed)
    assert "none.toml : ne peut pas être lu" in visitor.see("/bench?lang=fr").replace("\xa0", " ")
