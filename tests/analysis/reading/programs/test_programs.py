"""Files of jsPsych, Qualtrics, E-Prime and MATLAB: recognised with certainty, read or refused."""

import csv
import io
import json
import shlex
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import savemat

from slipscale import commands
from slipscale.analysis.load import load
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.analysis.reading.programs import e_prime, jspsych, qualtrics
from slipscale.analysis.reading.programs.table import Wanted, program_of
from slipscale.faults import UserError

LEVELS, PEOPLE = (0.5, 1.2, 2.3), ("p1", "p2", "p3")
ROWS = [
    (who, level, round(30 * level + number))
    for number, who in enumerate(PEOPLE)
    for level in LEVELS
]
WORDS = st.text(st.characters(codec="utf-8", exclude_categories=["Cs", "Cc"]), min_size=1).filter(
    lambda text: text.strip() == text and text[0] not in "{[\ufeff"
)
HERE = Path("data.csv")


def trials():
    """What jsPsych stores: an instruction, then a trial per row."""
    common = {"time_elapsed": 10, "subject": "p1"}
    yield {"trial_type": "instructions", "trial_index": 0, "response": None, **common}
    for index, (who, level, number) in enumerate(ROWS, start=1):
        answer = {"response": {"Q0": str(number)}, "level": level, "rt": 812.5}
        yield {
            "trial_type": "survey-text",
            "trial_index": index,
            **common,
            **answer,
            "subject": who,
        }


def as_csv(rows, separator=","):
    text = io.StringIO()
    csv.writer(text, delimiter=separator).writerows(rows)
    return text.getvalue()


def jspsych_csv(path):
    names = ["trial_type", "trial_index", "time_elapsed", "subject", "response", "level", "rt"]
    rows = [
        [
            json.dumps(cell) if isinstance(cell, dict) else "" if cell is None else cell
            for cell in (trial.get(name) for name in names)
        ]
        for trial in trials()
    ]
    path.write_text(as_csv([names, *rows]))


def jspsych_json(path):
    path.write_text(json.dumps(list(trials())))


def jatos(path):
    every = list(trials())
    path.write_text("\n".join(json.dumps(every[part::2]) for part in range(2)))


def of_qualtrics(path):
    names = ["ResponseId", "level_05", "level_12", "level_23"]
    texts = ["Response ID", 'How "slippery"?\nType a number', "How slippery?", "How slippery?"]
    ids = [json.dumps({"ImportId": f"QID{place}"}) for place in range(4)]
    body = [[who, *(number for other, _, number in ROWS if other == who)] for who in PEOPLE]
    path.write_bytes(as_csv([names, texts, ids, *body], "\t").encode("utf-16"))


def e_prime_log(path):
    lines = ["*** Header Start ***", "Experiment: slip", "Subject: 7", "*** Header End ***"]
    for number, (who, level, answer) in enumerate(ROWS):
        frame = [f"TrialNo: {number}", f"Amplitude: {level}", f"Answer.RESP: {answer}"]
        lines += ["\tLevel: 3", "\t*** LogFrame Start ***", *frame, "\t*** LogFrame End ***"]
        if level == LEVELS[-1]:
            # A block follows its trials.
            block = ["Level: 2", "*** LogFrame Start ***", f"Who: {who}", "*** LogFrame End ***"]
            lines += block
    path.write_bytes("\r\n".join(lines).encode("utf-16"))


def e_prime_export(path):
    head = ["C:\\data\\slip.edat3", "ExperimentName\tSubject\tAmplitude\tAnswer.RESP"]
    body = [f"slip\t{who}\t{level}\t{number}" for who, level, number in ROWS]
    path.write_bytes("\r\n".join([*head, *body]).encode("utf-16"))


def mat_vectors(path):
    who, level, number = zip(*ROWS, strict=True)
    savemat(path, {"who": np.array(who, object), "level": level, "number": number, "version": 2.0})


def mat_structures(path):
    dtype = [("who", object), ("level", object), ("number", object)]
    savemat(path, {"trials": np.array(ROWS, dtype)})


#: File name -> what writes it, its columns of participant, stimulus and response.
FILES = {
    "jspsych.csv": (jspsych_csv, ("subject", "level", "response.Q0")),
    "jspsych.json": (jspsych_json, ("subject", "level", "response.Q0")),
    "jatos.txt": (jatos, ("subject", "level", "response.Q0")),
    "log.txt": (e_prime_log, ("Who", "Amplitude", "Answer.RESP")),
    "export.txt": (e_prime_export, ("Subject", "Amplitude", "Answer.RESP")),
    "vectors.mat": (mat_vectors, ("who", "level", "number")),
    "structures.mat": (mat_structures, ("who", "level", "number")),
}


@pytest.mark.parametrize("name", FILES)
def test_every_programs_file_gives_the_same_estimates(tmp_path, name):
    write, columns = FILES[name]
    write(tmp_path / name)
    parts = dict(zip(("participant", "stimulus", "response"), columns, strict=True))
    found = load(tmp_path / name, parse_mapping({"columns": parts}, "here")).estimates
    rows = zip(
        found["participant_id"].astype(str),
        found["level"],
        found["estimate"],
        strict=True,
    )
    assert sorted(rows) == sorted(ROWS)


def test_qualtrics_three_headers_are_no_participants(tmp_path):
    path = tmp_path / "survey.tsv"
    of_qualtrics(path)
    levels = {"level_05": 0.5, "level_12": 1.2, "level_23": 2.3}
    mapping = {"columns": {"participant": "ResponseId"}, "levels": levels}
    found = load(path, parse_mapping(mapping, "here"))
    assert sorted(found.people) == list(PEOPLE)
    assert found.estimates["estimate"].sum() == sum(number for *_, number in ROWS)
    # The second header has two lines: the first response is on line 5.
    assert qualtrics.read(path.read_bytes(), path)["line"].tolist() == [5, 6, 7]


def test_an_ordinary_table_is_of_no_program():
    for text in ("subject,trial_type,rt\na,b,1\n", "Subject\tlevel\n1\t2\n", "[1, 2]", "", "{"):
        assert program_of(text.encode(), HERE) is None


@pytest.mark.parametrize(
    "name, content, words",
    [
        ("a.json", b'[{"trial_type": 1, "trial_index": 2, "time_elapsed": 3', "not readable JSON"),
        ("a.json", b'[{"trial_type": 1, "trial_index": 2, "time_elapsed": 3}, 4]', "entry 2 is 4"),
        ("a.txt", b"*** Header Start ***\nSubject: 1\n", "no complete frame"),
        ("a.mat", b"MATLAB 7.3 MAT-file, HDF5", "'-v7'"),
        ("a.mat", b"nonsense", "not a readable MATLAB file"),
    ],
)
def test_damaged_files_are_refused_in_a_sentence(name, content, words):
    path = Path(name)
    with pytest.raises(UserError, match=words):
        program_of(content, path).read(content, path, Wanted(words=(), sheet=None))


def test_of_several_tables_of_matlab_the_variable_is_named(tmp_path):
    path = tmp_path / "two.mat"
    savemat(path, {"first": {"a": [1, 2]}, "second": {"a": [3, 4], "b": [5.5, np.nan]}})
    content = path.read_bytes()
    program = program_of(content, path)
    with pytest.raises(UserError, match=r"these tables: first, second; expected .*--sheet"):
        program.read(content, path, Wanted(words=(), sheet=None))
    found = program.read(content, path, Wanted(words=(), sheet="second"))
    assert found["b"].tolist()[0] == 5.5
    assert found["b"].isna().tolist() == [False, True]


@given(
    st.lists(
        st.dictionaries(WORDS.filter(lambda t: "." not in t), st.none() | st.integers() | WORDS),
        min_size=1,
        max_size=4,
    )
)
def test_any_trials_of_jspsych_are_read_as_written(rows):
    rows = [{"trial_type": "t", "trial_index": 0, "time_elapsed": 1} | row for row in rows]
    found = jspsych.read(json.dumps(rows).encode(), Path("a.json"))
    for place, row in enumerate(rows):
        for name, value in row.items():
            if name != "line":
                cell = found[name].iloc[place]
                assert pd.isna(cell) if value is None else cell == value


@given(st.lists(st.tuples(WORDS, WORDS), min_size=1, max_size=4))
def test_any_answers_in_qualtrics_are_read_as_typed(answers):
    ids = [json.dumps({"ImportId": name}) for name in "ab"]
    text = as_csv([["a", "b"], ["x\ny", 'said "z"'], ids, *answers])
    assert qualtrics.recognises(text, HERE)
    found = qualtrics.read(text.encode(), HERE)
    assert list(zip(found["a"], found["b"], strict=True)) == answers


@given(st.lists(st.tuples(st.integers(2, 4), WORDS), min_size=1, max_size=6))
def test_any_log_of_e_prime_is_read_or_refused(frames):
    lines = ["*** Header Start ***", "Subject: 1", "*** Header End ***"]
    for level, value in frames:
        frame = [f"Level: {level}", "*** LogFrame Start ***", f"v: {value}"]
        lines += [*frame, "*** LogFrame End ***"]
    found = e_prime.read("\n".join(lines).encode(), Path("a.txt"))
    deepest = max(level for level, _ in frames)
    assert found["v"].tolist() == [value for level, value in frames if level == deepest]
    assert set(found["Subject"]) == {"1"}


def test_a_refusal_prints_a_command_that_works(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    jspsych_csv(tmp_path / "data.csv")
    assert commands.main(["analyse", "data.csv"]) == 2
    said = " ".join(capsys.readouterr().err.split()).partition("for example: ")[2]
    assert said == (
        "slipscale analyse data.csv --participant subject --stimulus level --response response.Q0 "
        "--map"
    )
    assert commands.main([*shlex.split(said)[1:], "--out", "results"]) == 0
    assert (tmp_path / "analysis.toml").exists()


def test_types_above_the_header_of_e_dataaid_are_skipped(tmp_path):
    table = pd.DataFrame(
        {"ExperimentName": "x", "Subject": ["a"] * 3, "level": [1, 2, 4], "loud": [2, 4, 9]}
    ).to_csv(sep="\t", index=False)
    types = "string\tinteger\tfloat\tfloat\n"
    (tmp_path / "data.txt").write_text(f"file.edat\n{types}{types}{types}{table}", "utf-16")
    columns = {"participant": "Subject", "stimulus": "level", "response": "loud"}
    data = load(tmp_path / "data.txt", parse_mapping({"columns": columns}, "here"))
    assert data.estimates["estimate"].tolist() == [2, 4, 9]


@pytest.mark.parametrize("separator", [",", ";", "\t", "json"])
def test_responses_of_jspsych_are_columns_in_every_kind_of_file(tmp_path, separator):
    trials = pd.DataFrame(
        {
            "trial_type": "survey-text",
            "trial_index": [0, 1, 2],
            "time_elapsed": [1, 2, 3],
            "subject": "a",
            "level": [1, 2, 4],
            "responses": [json.dumps({"Q0": text}) for text in ("2", "4", "9")],
        }
    )
    path = tmp_path / ("data.json" if separator == "json" else "data.csv")
    if separator == "json":
        path.write_text(trials.to_json(orient="records"))
    else:
        trials.to_csv(path, index=False, sep=separator)
    columns = {"participant": "subject", "stimulus": "level", "response": "responses.Q0"}
    data = load(path, parse_mapping({"columns": columns}, "here"))
    assert data.estimates["estimate"].tolist() == [2, 4, 9]


def test_single_values_next_to_vectors_of_matlab_are_in_every_row(tmp_path):
    savemat(
        tmp_path / "data.mat",
        {"S": {"subject": "ab", "gain": 2.0, "level": [1, 2, 4], "loud": [2.0, 4.0, 9.0]}},
    )
    columns = {"participant": "subject", "stimulus": "level", "response": "loud"}
    data = load(tmp_path / "data.mat", parse_mapping({"columns": columns}, "here"))
    assert data.estimates["estimate"].tolist() == [2, 4, 9]
    assert data.people == {"ab"}
