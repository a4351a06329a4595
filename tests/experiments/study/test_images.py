"""Images of friction maps: part of the study's text, whatever becomes of the file."""

import numpy as np
import pytest
from matplotlib.image import imsave

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.running.pilot import run_simulated
from slipscale.experiments.study.file import read_study
from slipscale.faults import UserError

STUDY = """
name = "maps"
title = "A map of friction"
[plate]
position = "simulated"
[[textures]]
name = "leaf"
kind = "map"
image = "{image}"
black_um_pp = 0.5
white_um_pp = 2.0
pixel_mm = 10.0
finger_speed_mm_s = 50.0
[[tasks]]
protocol = "magnitude_estimation"
practice = 0
repetitions = 1
"""


def written(folder, greys, image="leaf.png"):
    if greys is not None:
        imsave(folder / "leaf.png", np.array(greys, dtype=float), cmap="gray", vmin=0, vmax=255)
    path = folder / "maps.toml"
    path.write_text(STUDY.format(image=image), encoding="utf-8")
    return path


def test_an_image_is_inserted_into_the_study_and_a_session_needs_no_file(tmp_path, plan):
    path = written(tmp_path, [[0, 255], [51, 102]])
    study, text = read_study(str(path))
    (surface,) = study.texture_surfaces
    assert [surface.level_at(x, y) for y in (5, -5) for x in (-5, 5)] == pytest.approx(
        [0.5, 2.0, 0.8, 1.1]
    )
    (tmp_path / "leaf.png").unlink()
    run = plan(text, study_name="maps", seed=3, population="")
    run_simulated(tmp_path / "data", run, "mock")
    build_dataset(tmp_path / "data")
    (table,) = tmp_path.glob("data/sub-01/beh/*_beh.tsv")
    header, row = (line.split("\t") for line in table.read_text("utf-8").splitlines())
    found = dict(zip(header, row, strict=True))
    assert (found["texture"], found["amplitude_um_pp"], found["flag"]) == ("leaf", "2", "n/a")
    assert float(found["amplitude_readback_um_pp"]) == pytest.approx(1.1, abs=0.03)


@pytest.mark.parametrize(
    "greys, image, said",
    [
        (None, "leaf.png", "No such file or directory; expected a greyscale PNG"),
        (None, "maps.png", "it is not a PNG file"),
        (None, "../leaf.png", "without a folder"),
        (None, "leaf.jpg", "the name of a PNG file"),
        (
            [[0] * 200] * 100,
            "leaf.png",
            "200 x 100 pixels are too many; reduce the image to at most 16,384",
        ),
        ([[[1, 0, 0]]], "leaf.png", "must be greyscale"),
    ],
)
def test_a_file_that_is_no_map_is_refused_with_its_name(greys, image, said, tmp_path):
    path = written(tmp_path, greys, image)
    (tmp_path / "maps.png").write_text("not an image", encoding="utf-8")
    with pytest.raises(UserError, match=said):
        read_study(str(path))


def test_a_map_without_an_image_is_refused(tmp_path):
    path = written(tmp_path, None)
    path.write_text(path.read_text("utf-8").replace('image = "leaf.png"\n', ""), encoding="utf-8")
    with pytest.raises(UserError, match=r"image of item 1 of textures: is missing"):
        read_study(str(path))
