"""A small data set as `experiments.dataset.bids` writes it, for every test of the analysis."""

import hashlib
import json

import pytest

ESTIMATION_HEADER = [
    "trial",
    "block",
    "phase",
    "surface",
    "texture",
    "amplitude_um_pp",
    "amplitude_readback_um_pp",
    "estimate",
    "response_time",
    "exploration_time",
    "scale_top",
    "modulus",
    "response_time_source",
    "repeats",
    "flag",
]
DIFFERENCE_HEADER = [
    "trial",
    "series",
    "step",
    "phase",
    "amplitude_before_um_pp",
    "amplitude_um_pp",
    "amplitude_readback_um_pp",
    "catch",
    "difference_felt",
    "verbal_report",
    "confidence",
    "response_time",
    "repeats",
    "flag",
]
AMPLITUDES = (0.0, 0.5, 1.2, 2.3)
BASE = {0.0: 10, 0.5: 20, 1.2: 50, 2.3: 80}


def estimation_row(trial, amplitude, estimate, **others):
    row = dict.fromkeys(ESTIMATION_HEADER, "n/a") | {
        "trial": trial,
        "block": 1,
        "phase": "main",
        "amplitude_um_pp": amplitude,
        "amplitude_readback_um_pp": amplitude,
        "estimate": estimate,
        "response_time": 2.0,
        "scale_top": 100,
    }
    return row | others


def difference_row(trial, before, after, felt, **others):
    row = dict.fromkeys(DIFFERENCE_HEADER, "n/a") | {
        "trial": trial,
        "series": 1,
        "step": trial,
        "phase": "main",
        "amplitude_before_um_pp": before,
        "amplitude_um_pp": after,
        "catch": "true" if before == after else "false",
        "difference_felt": felt,
        "verbal_report": "less slippery" if felt == "yes" else "n/a",
    }
    return row | others


def write_tsv(path, header, rows, mode="participant", seed=1, *, study_hash="abc"):
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = ["\t".join(header)] + ["\t".join(str(row[name]) for name in header) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    sidecar = {
        "Slipscale": {
            "study": "biet2007",
            "study_hash": study_hash,
            "seed": seed,
            "mode": mode,
            "language": "en",
            "plate": "mock",
            "software": {"slipscale": "0.1.0"},
        }
    }
    path.with_suffix(".json").write_text(json.dumps(sidecar), encoding="utf-8")


def default_estimates(number, repetitions=2):
    """Main trials: participant ``number`` scales `BASE` by a factor of their own, plus noise."""
    rows = []
    for repetition in range(repetitions):
        for amplitude in AMPLITUDES:
            wobble = 1 + 0.03 * ((7 * number + 3 * repetition + int(10 * amplitude)) % 5 - 2)
            estimate = round(BASE[amplitude] * (0.8 + 0.02 * number) * wobble, 2)
            rows.append(estimation_row(len(rows) + 1, amplitude, estimate))
    return rows


@pytest.fixture
def dataset(tmp_path):
    """Write a BIDS folder; ``dataset(rows={"01": [...]})`` replaces what a participant said."""
    return _writer_in(tmp_path)


@pytest.fixture(scope="module")
def dataset_of_module(tmp_path_factory):
    """Write a BIDS folder for all tests of a module, as `dataset` does."""
    return _writer_in(tmp_path_factory.mktemp("dataset"))


def _writer_in(parent):
    def make(participants=6, rows=None, differences=None, mode="participant", choices=""):
        folder = parent / "data"
        study = f"[analysis]\n{choices}\n"
        common = {"study_hash": hashlib.sha256(study.encode()).hexdigest()}
        for number in range(1, participants + 1):
            label = f"{number:02d}"
            own = (rows or {}).get(label, default_estimates(number))
            stem = folder / f"sub-{label}" / "beh" / f"sub-{label}_task-"
            write_tsv(
                stem.with_name(stem.name + "magnitudeestimation_run-01_beh.tsv"),
                ESTIMATION_HEADER,
                own,
                mode=mode[label] if isinstance(mode, dict) else mode,
                seed=number,
                **common,
            )
            if differences is not None:
                write_tsv(
                    stem.with_name(stem.name + "descendingdifference_run-01_beh.tsv"),
                    DIFFERENCE_HEADER,
                    differences[label],
                    mode=mode[label] if isinstance(mode, dict) else mode,
                    **common,
                )
        description = {"Name": "A test study", "BIDSVersion": "1.10.0"}
        (folder / "dataset_description.json").write_text(json.dumps(description))
        if choices:
            (folder / "code").mkdir()
            (folder / "code" / "study.toml").write_text(study)
        return folder

    make.estimation_row = estimation_row
    make.difference_row = difference_row
    make.default_estimates = default_estimates
    return make


@pytest.fixture
def table_by_hand(tmp_path):
    """Write a tidy CSV from its text; return its path."""

    def make(text, name="study.csv", encoding="utf-8"):
        path = tmp_path / name
        path.write_text(text, encoding=encoding)
        return path

    return make


@pytest.fixture
def page():
    """Render an analysis's report, all figures but an empty Fig. 15 left out: they take seconds."""
    from slipscale.analysis.reporting.page import render

    return lambda analysis: render(analysis, {"fig15": "<svg></svg>"}, {"slipscale": "0"})
