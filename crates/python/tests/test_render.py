"""Pictures and clips."""

import concurrent.futures
import io

import numpy as np
import pytest
from conftest import SIZE
from PIL import Image

import sheer


def test_planes_have_the_stated_shapes_and_types(layers):
    picture = sheer.render(layers, size=SIZE, frames=4, background="none")
    width, height = SIZE
    assert picture.size == SIZE
    for name, dtype, channels in [
        ("colour", "float32", (4,)),
        ("alpha", "float32", ()),
        ("depth", "float32", ()),
        ("motion", "float32", (2,)),
        ("instance", "uint32", ()),
        ("primitive", "uint32", ()),
        ("transparent", "bool", ()),
    ]:
        plane = getattr(picture, name)
        assert (plane.shape, plane.dtype) == ((height, width, *channels), dtype), name
    assert picture.srgb().shape == (height, width, 4) and picture.srgb().dtype == "uint8"
    assert picture.displayed().shape == (height, width, 3) and picture.displayed().dtype == "float32"


def test_planes_are_no_copies_and_the_callers_own(layers):
    picture = sheer.render(layers, aa="none", size=SIZE)
    assert picture.colour is picture.colour
    assert np.shares_memory(picture.alpha, picture.colour)
    before = picture.srgb()
    picture.colour[:] = [0.0, 0.0, 0.0, 1.0]
    assert (picture.alpha == 1).all()
    assert (picture.srgb() == [0, 0, 0, 255]).all() and not (before == [0, 0, 0, 255]).all()


def test_colour_is_premultiplied_and_alpha_is_opacity(sheets):
    camera = sheer.Camera((0, 0, 2), (0, 0, 0), fov=60)
    white = sheets.with_environment("plain")
    picture = sheer.render(white, "baseline", aa="none", size=SIZE, background="none", camera=camera)
    # None to three sheets, of which each pixel sees whole ones.
    assert set(picture.alpha.round(5).ravel().tolist()) == {np.float32(1 - 0.6**n).round(5).item() for n in range(4)}
    nothing = picture.alpha == 0
    assert (picture.colour[nothing] == 0).all()
    np.testing.assert_array_equal(picture.transparent, ~nothing)
    # All sheets look alike, so that colour by opacity is the same wherever there is any.
    straight = picture.colour[~nothing][:, :3] / picture.alpha[~nothing][:, None]
    assert straight.std(axis=0).max() < 0.05 < straight.mean()
    # A method of one fragment knows where it is.
    picture = sheer.render(white, "joint", aa="none", size=SIZE, background="none", camera=camera)
    nothing = picture.alpha == 0
    assert set(np.unique(picture.alpha)) == {0, 1} and nothing.any()
    np.testing.assert_array_equal(np.isinf(picture.depth), nothing)
    np.testing.assert_array_equal(picture.instance == 2**32 - 1, nothing)
    np.testing.assert_array_equal(picture.primitive == 2**32 - 1, nothing)
    assert set(picture.depth[~nothing].round(3)) == {2.0, 2.5, 3.0}


@pytest.mark.parametrize(
    ("keywords", "options"),
    [
        ({"method": "joint", "frames": 5}, "-m joint -a layered --frames 5"),
        ({"method": "std:hybrid=0.5", "aa": "taa", "frames": 5, "seed": 3}, "-m std:hybrid=0.5 -a taa --frames 5 --seed 3"),
        ({"method": "weighted", "aa": "none"}, "-m weighted -a none"),
        ({"samples": 4, "shutter": 0.5, "first_frame": 6}, "--samples 4 --shutter 0.5 --first-frame 6"),
        (
            {"camera": sheer.Camera((2, 1.5, 3), (0, 1, 0), fov=50), "aa": "none", "background": "#336699"},
            "--eye 2,1.5,3 --target 0,1,0 --fov 50 -a none --background #336699",
        ),
        (
            {"camera": "orbit", "time": 2.5, "aa": "accumulate", "frames": 3, "tone": "agx", "exposure": 1, "shadow": "stochastic-map"},
            "--camera orbit --time 2.5 -a accumulate --frames 3 --tone agx --exposure 1 --shadow stochastic-map",
        ),
    ],
)
def test_a_picture_is_that_of_the_command_line(command_line, tmp_path, pane, keywords, options):
    command_line(f"render pane --size {SIZE[0]}x{SIZE[1]} {options} --quiet -o expected.png")
    picture = sheer.render(pane, size=SIZE, **keywords)
    picture.save(tmp_path / "found.png")
    with Image.open(tmp_path / "expected.png") as expected, Image.open(tmp_path / "found.png") as found:
        np.testing.assert_array_equal(np.array(expected), picture.srgb())
        np.testing.assert_array_equal(np.array(found), picture.srgb())
        same = {key: text for key, text in found.text.items() if expected.text.get(key) == text}
        assert {"sheer.method", "sheer.aa", "sheer.seed", "sheer.frame", "sheer.tone"} <= set(same), found.text
        differing = {key for key in found.text if key in expected.text and key not in same}
        assert differing == set(), differing


def test_what_notebooks_show_is_the_png(layers):
    picture = sheer.render(layers, aa="none", size=SIZE, background="none")
    with Image.open(io.BytesIO(picture._repr_png_())) as shown:
        np.testing.assert_array_equal(np.array(shown), picture.srgb())
        assert shown.text["sheer.method"] == "joint"


def test_an_exr_file_has_the_planes(command_line, tmp_path, layers):
    picture = sheer.render(layers, aa="none", size=SIZE)
    picture.save(tmp_path / "found.exr")
    command_line(f"render layers:count=3,alpha=0.4 -a none --size {SIZE[0]}x{SIZE[1]} --quiet -o expected.exr")
    figures = command_line("metrics expected.exr found.exr --json -")
    assert '"rms": 0.0' in figures, figures


def test_a_raw_frame_has_its_layers_and_its_jitter(layers):
    picture = sheer.render(layers, "joint", aa="layered", size=SIZE, raw=True)
    height, width = picture.alpha.shape
    split = picture.layers
    assert {name: plane.shape for name, plane in split.items()} == {
        "coverage": (height, width),
        "absorbed": (height, width, 3),
        "share": (height, width),
        "is_front": (height, width),
        "front_motion": (height, width, 2),
        "front_depth": (height, width),
        "back_motion": (height, width, 2),
        "back_depth": (height, width),
    }
    covered = split["coverage"] > 0
    np.testing.assert_allclose(split["coverage"][covered], 1 - 0.6**3, rtol=1e-5)
    assert covered.any() and (split["front_depth"][covered] < split["back_depth"][covered]).all()
    assert abs(float(picture.info["jitter.X"])) < 0.5
    assert sheer.render(layers, aa="none", size=SIZE).layers is None


def test_a_clip_is_rendered_frame_by_frame(pane):
    clip = sheer.sequence(pane, "joint", aa="taa", size=SIZE, frames=4, camera="path")
    assert len(clip) == 4
    frames = list(clip)
    assert [frame.info["frame"] for frame in frames] == ["0", "1", "2", "3"] and len(clip) == 0
    assert frames[0].info["time_secs"] == "0" and float(frames[3].info["time_secs"]) == pytest.approx(0.1)
    for count in (1, 4):
        still = sheer.render(pane, "joint", aa="taa", size=SIZE, frames=count, camera="path")
        np.testing.assert_array_equal(still.colour, frames[count - 1].colour)
    # Frames do not change when later ones are rendered.
    assert np.abs(frames[0].colour - frames[3].colour).max() > 0


def test_a_part_of_a_clip_is_warmed_up(pane):
    def last(**keywords):
        *_, frame = sheer.sequence(pane, "joint", aa="taa", size=SIZE, camera="path", **keywords)
        return frame

    whole = last(frames=6)
    part = last(first_frame=5, frames=1, warm_up=5)
    np.testing.assert_array_equal(part.colour, whole.colour)
    assert part.info["frame"] == "5"
    np.testing.assert_array_equal(last(first_frame=5, frames=1).colour, whole.colour)
    assert np.abs(last(first_frame=5, frames=1, warm_up=0).colour - whole.colour).max() > 0.01


def test_samples_of_a_clip_owe_nothing_to_other_frames(pane):
    frames = list(sheer.sequence(pane, size=SIZE, frames=3, samples=2, camera="path"))
    alone = sheer.render(pane, size=SIZE, samples=2, first_frame=2, camera="path")
    np.testing.assert_array_equal(frames[2].colour, alone.colour)
    assert frames[2].info["samples"] == "2"


def test_seeds_differ_and_threads_do_not(pane):
    def colour(**keywords):
        return sheer.render(pane, "std", aa="none", size=SIZE, **keywords).colour

    np.testing.assert_array_equal(colour(threads=1), colour(threads=3))
    assert np.abs(colour(seed=1) - colour()).max() > 0.01


def test_threads_of_python_render_side_by_side(pane):
    with concurrent.futures.ThreadPoolExecutor(3) as pool:
        of_threads = list(pool.map(lambda seed: sheer.render(pane, "std", size=SIZE, frames=3, seed=seed), range(3)))
    for seed, picture in enumerate(of_threads):
        alone = sheer.render(pane, "std", size=SIZE, frames=3, seed=seed)
        np.testing.assert_array_equal(picture.colour, alone.colour)
