"""Methods against the exact answer, and figures of arrays."""

import json

import numpy as np
import pytest
from conftest import SIZE
from PIL import Image

import sheer
from sheer import metrics

TIMES = ("ms_median", "ms_min", "ms_max")


def without_times(rows):
    return [{key: value for key, value in row.items() if key not in TIMES} for row in rows]


def test_rows_are_those_of_the_command_line(command_line, tmp_path):
    command_line(
        f"compare pane --camera path -m std -m weighted -a taa -a none --reference same,truth:samples=4"
        f" --size {SIZE[0]}x{SIZE[1]} --frames 4 --seed 7 --quiet -o report"
    )
    report = json.loads((tmp_path / "report" / "report.json").read_text())
    keywords = {"aa": ["taa", "none"], "reference": ["same", "truth:samples=4"], "size": SIZE, "frames": 4}
    rows = sheer.compare("pane", ["std", "weighted"], camera="path", seed=7, **keywords)
    assert without_times(rows) == without_times(report["rows"])
    assert [list(row) for row in rows] == [list(row) for row in report["rows"]]
    assert len(rows) == 12 and all(row["ms_min"] <= row["ms_median"] <= row["ms_max"] for row in rows)
    # Another seed is another picture.
    others = sheer.compare("pane", ["std", "weighted"], camera="path", seed=8, **keywords)
    assert without_times(others) != without_times(rows)


def test_without_a_size_it_is_that_of_the_command_line(command_line, tmp_path):
    command_line("compare layers:count=2 -m std -a none --frames 1 --quiet -o report")
    report = json.loads((tmp_path / "report" / "report.json").read_text())
    rows = sheer.compare("layers:count=2", "std", aa="none", frames=1)
    assert without_times(rows) == without_times(report["rows"])


def test_the_reference_equals_itself_and_one_name_will_do(pane):
    reference, std = sheer.compare(pane, "std", aa="none", size=SIZE, frames=2)
    assert (reference["method"], reference["psnr_db"], reference["rms"]) == ("baseline", None, 0.0)
    assert reference["ssim"] == pytest.approx(1, abs=1e-6)
    assert std["method"] == "std" and std["ssim"] < 1 and std["rms"] > 0


def test_rows_are_the_figures_of_the_pictures(pane):
    pictures = [sheer.render(pane, method, aa="none", size=SIZE) for method in ("baseline", "std")]
    _, row = sheer.compare(pane, "std", aa="none", size=SIZE, frames=1)
    displayed = [picture.displayed() for picture in pictures]
    linear = [picture.colour[..., :3] for picture in pictures]
    assert metrics.ssim(*displayed) == row["ssim"]
    assert metrics.psnr(*displayed) == row["psnr_db"]
    assert metrics.flip(*displayed) == row["flip"]
    assert metrics.rms(*linear) == row["rms"]
    assert metrics.bias(*linear) == row["bias"]


@pytest.fixture
def noise():
    """A picture and the same with noise."""
    random = np.random.default_rng(1)
    reference = random.random((40, 60, 3), dtype="float32")
    return reference, np.clip(reference + 0.1 * random.standard_normal((40, 60, 3)), 0, 1).astype("float32")


def test_figures_are_what_they_are_called(noise):
    reference, image = noise
    error = image.astype("float64") - reference
    assert metrics.rms(reference, image) == pytest.approx(np.sqrt((error**2).mean()), rel=1e-6)
    assert metrics.bias(reference, image) == pytest.approx(error.mean(), abs=1e-7)
    assert metrics.bias(image, reference) == pytest.approx(-error.mean(), abs=1e-7)
    assert metrics.psnr(reference, image) == pytest.approx(-10 * np.log10((error**2).mean()), rel=1e-6)
    assert metrics.psnr(image, image) == np.inf
    assert metrics.ssim(image, image) == pytest.approx(1, abs=1e-6) and 0 < metrics.ssim(reference, image) < 1
    assert metrics.flip(image, image) == 0 and 0 < metrics.flip(reference, image) < 1
    assert metrics.ssim_map(reference, image).shape == (40, 60, 3)
    # The mean is over windows that lie inside the picture.
    assert metrics.ssim_map(reference, image)[5:-5, 5:-5].mean() == pytest.approx(metrics.ssim(reference, image), rel=1e-5)
    assert metrics.flip_map(reference, image).mean() == pytest.approx(metrics.flip(reference, image), rel=1e-5)
    near, far = (metrics.flip_map(reference, image, pixels_per_degree=density).mean() for density in (30, 200))
    assert far < near
    shown = metrics.error_map(reference, image)
    assert shown.shape == (40, 60, 4) and shown.dtype == "uint8" and (shown[..., 3] == 255).all()


def test_clips_are_lists_or_arrays(noise):
    reference, image = noise
    still, blinking = [reference] * 4, [reference, image] * 2
    assert metrics.flicker(still, [image] * 4) == pytest.approx(0, abs=1e-6)
    assert metrics.flicker(still, blinking) > 0.01
    assert metrics.flicker(np.stack(still), np.stack(blinking)) == metrics.flicker(still, blinking)
    change = (image - reference).astype("float64")
    assert metrics.tpsnr(still, blinking) == pytest.approx(-10 * np.log10((change**2).mean()), rel=1e-5)
    assert metrics.tpsnr(still, still) == np.inf and metrics.tpsnr(still[:1], still[:1]) is None
    large = [np.tile(frame, (2, 2, 1)) for frame in blinking]
    assert metrics.vdp(large, large) == pytest.approx(10, abs=1e-3)
    assert metrics.vdp(large, [1 - frame for frame in large]) < 9


def test_bytes_are_pictures_of_a_display(noise):
    bytes_ = [(255 * picture).round().astype("uint8") for picture in noise]
    floats = [picture.astype("float32") / np.float32(255) for picture in bytes_]
    assert metrics.ssim(*bytes_) == pytest.approx(metrics.ssim(*floats), rel=1e-6)
    assert metrics.psnr(bytes_[0].astype("float64") / 255, floats[1]) == pytest.approx(metrics.psnr(*bytes_), rel=1e-5)
    with pytest.raises(TypeError, match="reference: give floats, linear light"):
        metrics.rms(*bytes_)


def test_figures_of_files_are_those_of_the_command_line(command_line, tmp_path, pane):
    for name, method in [("a", "baseline"), ("b", "std")]:
        sheer.render(pane, method, aa="none", size=SIZE, background="#000000").save(tmp_path / f"{name}.png")
    [row] = json.loads(command_line("metrics a.png b.png --json -"))["rows"]
    pictures = []
    for name in "ab":
        with Image.open(tmp_path / f"{name}.png") as image:
            pictures.append(np.array(image.convert("RGB")))
    assert metrics.ssim(*pictures) == pytest.approx(row["ssim"], rel=1e-5)
    assert metrics.psnr(*pictures) == pytest.approx(row["psnr_db"], rel=1e-5)
    assert metrics.flip(*pictures) == pytest.approx(row["flip"], rel=1e-4)
