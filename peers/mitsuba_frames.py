"""Whole frames of Mitsuba 3 and of Sheer: the same glTF scene, as much time as it takes for the same error.

The scene is unlit, with opacity at its vertices. For Mitsuba that is emission premultiplied by alpha, since the
mask does not attenuate what its own surface emits, around a black inside; the inside is a mirror rather than
diffuse, so that no light is sampled there and Mitsuba has half the work. Both renderers use all threads, a box
filter, and take turns. The figures go to stdout as JSON, talk to stderr.
"""

import argparse
import json
import math
import pathlib
import statistics
import subprocess
import sys
import time

import numpy

# More than any ray meets; Mitsuba counts each layer that a path passes.
MAX_DEPTH = 512
# Of the sum over all blocks of the picture; what two renderers of one scene differ by more than once in a
# million times is no noise.
LEAST_P = 1e-6
BLOCK_PX = 16
# Frames of `baseline` in the reference, and the most that are tried.
REFERENCE_FRAMES = 128
MOST_FRAMES = 128


def talk(text):
    print(f"mitsuba: {text}", file=sys.stderr, flush=True)


def use_mitsuba(variant):
    try:
        import mitsuba
    except ImportError:
        sys.exit("mitsuba is not installed: pip install -r peers/requirements.txt")
    mitsuba.set_variant(variant)
    return mitsuba


def accessor(document, binary, index, kind, width):
    """The rows of an accessor."""
    entry = document["accessors"][index]
    view = document["bufferViews"][entry["bufferView"]]
    begin = view.get("byteOffset", 0)
    count = entry["count"] * width
    return numpy.frombuffer(binary, kind, count, begin).reshape(-1, width)


def load(mitsuba, path, size):
    """The scene of a glTF file with one mesh, as `sheer-peers` writes it."""
    document = json.loads(path.read_text())
    binary = (path.parent / document["buffers"][0]["uri"]).read_bytes()
    primitive = document["meshes"][0]["primitives"][0]
    attributes = primitive["attributes"]
    positions = accessor(document, binary, attributes["POSITION"], "<f4", 3)
    colours = accessor(document, binary, attributes["COLOR_0"], "<f4", 4)
    indices = accessor(document, binary, primitive["indices"], "<u4", 1).reshape(-1, 3)

    alpha = {"type": "mesh_attribute", "name": "vertex_alpha"}
    properties = mitsuba.Properties()
    properties["bsdf"] = mitsuba.load_dict({
        "type": "mask",
        "opacity": alpha,
        "nested": {"type": "conductor", "specular_reflectance": {"type": "rgb", "value": 0.0}},
    })
    properties["emitter"] = mitsuba.load_dict({
        "type": "area",
        "radiance": {"type": "mesh_attribute", "name": "vertex_radiance"},
    })
    properties["face_normals"] = True
    mesh = mitsuba.Mesh("smoke", len(positions), len(indices), properties)
    mesh.add_attribute("vertex_alpha", 1, numpy.ascontiguousarray(colours[:, 3]))
    mesh.add_attribute("vertex_radiance", 3, (colours[:, :3] * colours[:, 3:]).ravel())
    values = mitsuba.traverse(mesh)
    values["vertex_positions"] = positions.ravel()
    values["faces"] = indices.ravel()
    values.update()
    mesh.initialize()

    camera = document["cameras"][0]["perspective"]
    node = next(node for node in document["nodes"] if "camera" in node)
    eye = node["translation"]
    return mitsuba.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": MAX_DEPTH, "rr_depth": MAX_DEPTH},
        "sensor": {
            "type": "perspective",
            "fov": math.degrees(camera["yfov"]),
            "fov_axis": "y",
            "near_clip": 1e-3,
            "to_world": mitsuba.ScalarTransform4f().look_at(eye, [eye[0], eye[1], eye[2] - 1], [0, 1, 0]),
            "film": {
                "type": "hdrfilm",
                "width": size[0],
                "height": size[1],
                "pixel_format": "rgb",
                "component_format": "float32",
                "rfilter": {"type": "box"},
            },
            "sampler": {"type": "independent"},
        },
        "smoke": mesh,
        # Black surroundings: without any, the path integrator drops what a path saw that passed every mask.
        "surroundings": {"type": "constant", "radiance": {"type": "rgb", "value": 0.0}},
    })


def render(mitsuba, scene, samples, seed):
    """A picture and the seconds it took."""
    start = time.perf_counter()
    picture = numpy.array(mitsuba.render(scene, spp=samples, seed=seed))
    return picture, time.perf_counter() - start


class Sheer:
    def __init__(self, program, scene, size, folder):
        self.program, self.scene, self.folder = program, scene, folder
        self.common = ["--size", f"{size[0]}x{size[1]}", "--background", "#000000", "--quiet"]

    def run(self, verb, *arguments):
        command = [self.program, verb, self.scene, *self.common, *arguments]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"sheer {verb} failed: {done.stderr}")
        return done.stdout

    def picture(self, mitsuba, method, frames):
        path = self.folder / f"{method}-{frames}.exr"
        self.run("render", "-m", method, "-a", "accumulate", "--frames", frames, "-o", path)
        bitmap = mitsuba.Bitmap(str(path))
        names = [field.name for field in bitmap.struct_()]
        values = numpy.array(bitmap).astype(numpy.float64)
        return numpy.stack([values[..., names.index(channel)] for channel in "RGB"], axis=-1)

    def frame_ms(self, methods, frames):
        asked = [word for method in methods for word in ("-m", method)]
        report = json.loads(self.run("bench", *asked, "--frames", frames, "--json", "-"))
        return {row["method"]: row["whole_ms_median"] for row in report["rows"]}


def rms(picture, reference):
    return float(numpy.sqrt(numpy.mean((picture - reference) ** 2)))


def smallest_p(pictures, reference):
    """How likely the largest difference between the mean of noisy pictures and a reference is, if they show the
    same: each block's mean in units of its error, estimated from the noise within the block, corrected for the
    number of blocks after Šidák."""
    difference = numpy.mean(pictures, axis=0).mean(axis=-1) - reference.mean(axis=-1)
    height, width = (extent // BLOCK_PX * BLOCK_PX for extent in difference.shape)
    blocks = difference[:height, :width].reshape(height // BLOCK_PX, BLOCK_PX, -1, BLOCK_PX)
    blocks = blocks.transpose(0, 2, 1, 3).reshape(-1, BLOCK_PX * BLOCK_PX)
    error = blocks.std(axis=1, ddof=1) / BLOCK_PX
    seen = error > 0
    if (blocks[~seen] != 0).any():
        return 0.0
    largest = numpy.abs(blocks[seen].mean(axis=1) / error[seen]).max()
    single = math.erfc(largest / math.sqrt(2))
    return -math.expm1(int(seen.sum()) * math.log1p(-single)) if single < 1 else 1.0


def fewest_frames(error, target):
    """How many frames bring the error down to a target, doubled until they do, then halved in between; none if
    the most do not. And the error then."""
    high = 1
    while (found := error(high)) > target:
        if high == MOST_FRAMES:
            return None, found
        high *= 2
    low = high // 2
    while high - low > 1:
        middle = (low + high) // 2
        tried = error(middle)
        if tried > target:
            low = middle
        else:
            high, found = middle, tried
    return high, found


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sheer", required=True, type=pathlib.Path, help="the program")
    parser.add_argument("--scene", required=True, type=pathlib.Path, help="glTF file that sheer-peers wrote")
    parser.add_argument("--folder", required=True, type=pathlib.Path, help="for pictures")
    parser.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba")
    parser.add_argument("--size", type=int, nargs=2, default=(240, 136))
    parser.add_argument("--samples", type=int, default=64, help="a pixel, of Mitsuba")
    parser.add_argument("--rounds", type=int, default=7)
    arguments = parser.parse_args()

    mitsuba = use_mitsuba(arguments.variant)
    talk(f"{mitsuba.__version__}, {mitsuba.variant()}")
    sheer = Sheer(arguments.sheer, arguments.scene, arguments.size, arguments.folder)
    methods = ["baseline", "joint", "roulette", "std"]
    reference = sheer.picture(mitsuba, "baseline", REFERENCE_FRAMES)

    # The first picture compiles the kernels and is not timed.
    scene = load(mitsuba, arguments.scene, arguments.size)
    render(mitsuba, scene, arguments.samples, 0)
    pictures, seconds, frame_ms = [], [], {method: [] for method in methods}
    for turn in range(arguments.rounds):
        picture, took = render(mitsuba, scene, arguments.samples, turn + 1)
        pictures.append(picture)
        seconds.append(took)
        for method, ms in sheer.frame_ms(methods, 3).items():
            frame_ms[method].append(ms)
        latest = ", ".join(f"{method} {times[-1]:.1f} ms" for method, times in frame_ms.items())
        talk(f"round {turn + 1} of {arguments.rounds}: {took:.2f} s; {latest} a frame")

    p = smallest_p(pictures, reference)
    control = smallest_p(pictures, reference * 1.02)
    if p < LEAST_P:
        sys.exit(f"Mitsuba shows something else than Sheer (p = {p:.1e}): no time to compare")
    if control >= LEAST_P:
        sys.exit(f"too few samples to see a picture that is wrong by 2 % (p = {control:.1e}): raise --samples")

    target = statistics.median(rms(picture, reference) for picture in pictures)
    rows = []
    for method in methods:
        frames, error = fewest_frames(lambda count: rms(sheer.picture(mitsuba, method, count), reference), target)
        rows.append({"method": method, "frames": frames, "rms": error, "frame_ms": frame_ms[method]})
    json.dump(
        {
            "version": mitsuba.__version__,
            "variant": mitsuba.variant(),
            "size": list(arguments.size),
            "samples": arguments.samples,
            "reference_frames": REFERENCE_FRAMES,
            "most_frames": MOST_FRAMES,
            "ms": [1e3 * took for took in seconds],
            "rms": target,
            "p": p,
            "rows": rows,
        },
        sys.stdout,
    )


if __name__ == "__main__":
    main()
