"""What goes wrong is an exception of the right kind, with words that say what to do, and never the end."""

import pathlib
import subprocess
import sys

import numpy as np
import pytest

import sheer

POINTS = np.eye(3)
PICTURE = np.zeros((20, 20, 3))


def render(**keywords):
    return lambda: sheer.render("layers:count=1", **{"size": (8, 8), "aa": "none", **keywords})


def from_arrays(*arrays, **keywords):
    return lambda: sheer.Scene.from_arrays(*arrays, **keywords)


@pytest.mark.parametrize(
    ("what", "kind", "words"),
    [
        (lambda: sheer.open("no-such-file.glb"), FileNotFoundError, "cannot read no-such-file.glb"),
        (lambda: sheer.open(pathlib.Path("no-such-file.glb")), FileNotFoundError, "no-such-file.glb"),
        (lambda: sheer.open("layer"), ValueError, r"neither a built-in.*`sheer.scenes\(\)`.*'layers'"),
        (lambda: sheer.open("layers:count=-1"), ValueError, "scene 'layers': .*count"),
        (lambda: sheer.open(b"glTF and nothing else"), sheer.SheerError, "bytes: "),
        (lambda: sheer.open(b"what is this"), ValueError, "is not a .gltf"),
        (lambda: sheer.open(b""), ValueError, "is not a .gltf"),
        (lambda: sheer.open(7), TypeError, "give the name of a built-in scene"),
        (lambda: sheer.open("pane", clip="walk"), ValueError, "no clip 'walk'"),
        (lambda: sheer.open("pane", name="pane.glb"), ValueError, "name is for bytes"),
        (from_arrays(np.eye(4)), ValueError, r"positions: its shape is \[4, 4\]; give \(vertices, 3\)"),
        (from_arrays(POINTS, [[0, 1]]), ValueError, r"give \(triangles, 3\)"),
        (from_arrays(POINTS, [[0, 1, 3]]), ValueError, "index"),
        (from_arrays(POINTS, [[0, 1, -1]]), ValueError, r"indices\[0\] is .*below 0"),
        (from_arrays(POINTS, [[0, 1, 2**40]]), ValueError, "above 32 bits"),
        (from_arrays(POINTS, [[0.0, 1.0, 2.0]]), TypeError, "indices: give integers"),
        (from_arrays(POINTS[:2]), ValueError, "2 positions are no triangles"),
        (from_arrays(POINTS * np.nan), ValueError, "not finite"),
        (from_arrays(np.array(["a"])), TypeError, "holds no numbers"),
        (from_arrays(POINTS, rgba=[1, 1, 1]), ValueError, r"\(4,\) or \(3, 4\)"),
        (from_arrays(POINTS, rgba=[1.0, 1.0, 1.0, 1.5]), ValueError, "from 0 to 1"),
        (from_arrays(POINTS, rgba=[1, 1, 1, 1]), TypeError, "uint8"),
        (from_arrays(POINTS, normals=POINTS[:2]), ValueError, "normals"),
        (render(method="stdd"), ValueError, "no method 'stdd'.*the nearest is 'std'"),
        (render(method="std:hybrid=x"), ValueError, "method 'std'"),
        (render(aa="tea"), ValueError, "no anti-aliasing 'tea'.*'taa'"),
        (render(shadow="depp"), ValueError, "'deep'"),
        (render(tone="filmic"), ValueError, "pbr-neutral"),
        (render(background="blue"), ValueError, 'background is "blue": give env, none or a colour'),
        (render(camera="front"), ValueError, "no camera 'front'; it has: "),
        (render(camera=3), TypeError, "camera: give the name"),
        (render(camera=sheer.Camera((1, 1, 1), (1, 1, 1))), ValueError, "no direction to look in"),
        (render(size=(0, 8)), ValueError, r"size is \(0, 8\)"),
        (render(size=(8, 100000)), ValueError, "from 1 to 16384"),
        (render(frames=0), ValueError, "frames is 0"),
        (render(samples=0), ValueError, "samples is 0"),
        (render(shutter=0.5), ValueError, "shutter"),
        (render(samples=2, raw=True), ValueError, "raw"),
        (render(fps=0), ValueError, "fps is 0"),
        (render(time=np.inf), ValueError, "time is inf"),
        (render(threads=0), ValueError, "threads is 0"),
        (lambda: sheer.render("pane", size=(8, 8), aa="none").save("a.jpg"), ValueError, ".png or .exr"),
        (lambda: sheer.render("pane", size=(8, 8), aa="none").save("no/a.png"), FileNotFoundError, "create it first"),
        (lambda: sheer.Camera(fov=200), ValueError, "fov is 200: give degrees from 0.001 to 179"),
        (lambda: sheer.Camera(fov=50, ortho=2), ValueError, "not both"),
        (lambda: sheer.Camera(target=(0, 0, 0)), ValueError, "needs an eye"),
        (lambda: sheer.Camera(eye=(0, 0, np.nan)), ValueError, "not finite"),
        (lambda: sheer.open("pane").with_alpha(2), ValueError, "alpha is 2"),
        (lambda: sheer.open("pane").with_environment("studo"), ValueError, "the nearest is 'studio'"),
        (lambda: sheer.compare("pane", []), ValueError, "methods: give one name at least"),
        (lambda: sheer.compare("pane", "std", reference="truht"), ValueError, "truth"),
        (lambda: sheer.compare("pane", "std", reference=["truth", "truth:samples=4"]), ValueError, "one truth"),
        (lambda: sheer.compare("pane", "std", vdp=True, size=(3, 8)), ValueError, "vdp judges pictures from"),
        (lambda: sheer.metrics.ssim(PICTURE, PICTURE[:10]), ValueError, "20x10 pixels with a reference of 20x20"),
        (lambda: sheer.metrics.ssim(PICTURE, PICTURE[..., 0]), ValueError, r"image: its shape is \[20, 20\]"),
        (lambda: sheer.metrics.psnr(PICTURE.astype(int), PICTURE), TypeError, "reference: give floats"),
        (lambda: sheer.metrics.flicker([PICTURE], []), ValueError, "0 frames with 1 reference frames"),
        (lambda: sheer.metrics.flip_map(PICTURE, PICTURE, 0), ValueError, "pixels_per_degree is 0"),
        (lambda: sheer.metrics.vdp([PICTURE[:2, :2]], [PICTURE[:2, :2]]), sheer.SheerError, "ColorVideoVDP"),
    ],
)
def test_errors_say_what_is_wrong(what, kind, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(kind, match=words) as raised:
        what()
    assert "--" not in str(raised.value), "options are those of the command line"
    assert list(tmp_path.iterdir()) == []


def test_memory_has_a_limit_in_words_of_python():
    with pytest.raises(sheer.SheerError, match="raise memory_limit=") as raised:
        sheer.open(pathlib.Path(__file__).parents[3] / "assets/formats/pane.ply", memory_limit=1000)
    assert "--" not in str(raised.value)


@pytest.mark.parametrize(
    "long",
    [
        'sheer.render("pane", "std", size=(32, 18), frames=1000000)',
        'sheer.render("pane", "std", size=(32, 18), samples=65536)',
        'list(sheer.sequence("pane", "std", size=(32, 18), frames=1000000))',
        'sheer.compare("pane", "std", size=(32, 18), frames=1000000)',
        'sheer.compare("pane", "std", size=(32, 18), frames=4, reference="truth:samples=4096")',
    ],
)
def test_a_key_interrupts_what_is_long(long):
    # The thread that interrupts runs at all because rendering does not hold Python's lock.
    script = f"""
import _thread, signal, threading, sheer
signal.signal(signal.SIGINT, signal.default_int_handler)
threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT)).start()
try:
    {long}
except KeyboardInterrupt:
    print("interrupted", sheer.render("pane", size=(8, 8), aa="none").size)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert done.stdout == "interrupted (8, 8)\n", done.stderr
