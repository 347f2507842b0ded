"""Scenes from files, bytes and arrays."""

import pathlib

import numpy as np
import pytest
import trimesh

import sheer

FORMATS = pathlib.Path(__file__).parents[3] / "assets" / "formats"


def plane(alpha, n=1):
    """A square of side 2 that looks along +Z, of 2 n² triangles."""
    x, y = np.meshgrid(np.linspace(-1, 1, n + 1), np.linspace(-1, 1, n + 1))
    positions = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).reshape(-1, 1)
    indices = np.concatenate([corner + [0, 1, n + 2], corner + [0, n + 2, n + 1]])
    rgba = np.full((len(positions), 4), [1.0, 0.25, 0.0, alpha])
    return positions, indices, rgba


@pytest.mark.filterwarnings("ignore::sheer.SheerWarning")
def test_a_name_a_path_and_bytes_open_the_same():
    assert "pane" in sheer.scenes()
    assert sheer.open("pane").name == "pane"
    path = FORMATS / "pane.ply"
    by_path, by_text = sheer.open(path), sheer.open(str(path))
    by_bytes = sheer.open(path.read_bytes())
    by_array = sheer.open(bytearray(path.read_bytes()))
    hashes = {scene.content_hash() for scene in (by_path, by_text, by_bytes, by_array)}
    assert len(hashes) == 1 and hashes != {sheer.open("pane").content_hash()}
    # What begins like nothing else is known by its name.
    obj = (FORMATS / "pane.obj").read_bytes()
    with pytest.raises(ValueError, match="is not a .gltf"):
        sheer.open(obj)
    named = sheer.open(obj, name=str(FORMATS / "pane.obj"))
    assert named.content_hash() == sheer.open(FORMATS / "pane.obj").content_hash()


@pytest.mark.filterwarnings("ignore::sheer.SheerWarning")
def test_what_is_lost_of_a_file_is_a_warning_or_an_error():
    text = (FORMATS / "pane.obj").read_bytes() + b"\nf 1 2 99999\n"
    name = str(FORMATS / "broken.obj")
    with pytest.warns(sheer.SheerWarning, match="99999"):
        scene = sheer.open(text, name=name)
    assert any("99999" in warning for warning in scene.warnings)
    with pytest.raises(sheer.SheerError, match="99999.*without strict= the rest is drawn"):
        sheer.open(text, name=name, strict=True)
    assert sheer.open(FORMATS / "pane.ply").warnings == []


def test_a_hundred_thousand_triangles_come_from_arrays():
    positions, indices, rgba = plane(0.4, n=224)
    scene = sheer.Scene.from_arrays(positions, indices, rgba)
    assert scene.triangle_count == len(indices) == 100352
    np.testing.assert_array_equal(scene.bounds, [positions.min(axis=0), positions.max(axis=0)])
    # Every pixel sees one layer of the plane, however many triangles it has.
    for fine in (scene, sheer.Scene.from_arrays(*plane(0.4))):
        picture = sheer.render(
            fine, "baseline", aa="none", size=(32, 18), background="none", camera=sheer.Camera((0, 0, 1), fov=40)
        )
        np.testing.assert_allclose(picture.alpha, 0.4, rtol=1e-6)


@pytest.mark.parametrize("dtype", ["int8", "int32", "int64", "uint16", "uint32", "uint64"])
def test_types_and_order_in_memory_do_not_matter(dtype):
    positions, indices, rgba = plane(0.4)
    expected = sheer.Scene.from_arrays(positions.astype("float32"), indices, rgba.astype("float32")).content_hash()
    fortran = np.asfortranarray(positions.astype("float64"))
    found = sheer.Scene.from_arrays(fortran, indices.astype(dtype), rgba[::-1][::-1])
    assert found.content_hash() == expected
    assert sheer.Scene.from_arrays(positions.tolist(), indices.tolist(), rgba.tolist()).content_hash() == expected
    # Colour of all is another thing than one a vertex, and looks the same; another alpha does not.
    of_all = sheer.Scene.from_arrays(positions, indices, rgba[0])
    vertices = positions[indices.ravel()]
    by_threes = sheer.Scene.from_arrays(vertices, rgba=rgba[0])
    pictures = [
        sheer.render(scene, "baseline", aa="none", size=(16, 9)).colour
        for scene in (found, of_all, by_threes, sheer.Scene.from_arrays(positions, indices, rgba * 0.5))
    ]
    np.testing.assert_allclose(pictures[1], pictures[0], rtol=1e-5)
    np.testing.assert_allclose(pictures[2], pictures[1], rtol=1e-5)
    assert np.abs(pictures[3] - pictures[0]).max() > 0.01


def test_bytes_are_srgb_and_floats_linear():
    positions, indices, _ = plane(1)
    of_bytes = sheer.Scene.from_arrays(positions, indices, np.array([188, 255, 0, 102], dtype="uint8"))
    linear = ((188 / 255 + 0.055) / 1.055) ** 2.4
    of_floats = sheer.Scene.from_arrays(positions, indices, [linear, 1, 0, 0.4])
    shown = [sheer.render(scene, "baseline", aa="none", size=(16, 9)).colour for scene in (of_bytes, of_floats)]
    np.testing.assert_allclose(shown[0], shown[1], atol=1e-6)


def test_normals_round_what_is_flat_without():
    sphere = trimesh.creation.icosphere(subdivisions=1)
    flat = sheer.Scene.from_arrays(sphere.vertices, sphere.faces)
    smooth = sheer.Scene.from_arrays(sphere.vertices, sphere.faces, normals=7.0 * sphere.vertices)
    shown = [sheer.render(scene, "baseline", aa="none", size=(32, 18)).instance for scene in (flat, smooth)]
    np.testing.assert_array_equal(*shown)
    colours = [sheer.render(scene, "baseline", aa="none", size=(32, 18)).colour for scene in (flat, smooth)]
    assert np.abs(colours[0] - colours[1]).max() > 0.01


def test_trimesh_hands_over_its_glb():
    ball = trimesh.creation.icosphere(subdivisions=3, radius=2.0)
    ball.visual = trimesh.visual.TextureVisuals(
        material=trimesh.visual.material.PBRMaterial(
            baseColorFactor=[255, 128, 0, 102], alphaMode="BLEND", doubleSided=True
        )
    )
    scene = sheer.open(trimesh.Scene(ball).export(file_type="glb"))
    assert scene.triangle_count == len(ball.faces)
    np.testing.assert_allclose(scene.bounds, ball.bounds, rtol=1e-6)
    picture = sheer.render(scene, "baseline", aa="none", size=(33, 33), background="none")
    # Front and back of the ball, of opacity 0.4 each, and nothing beside it.
    alpha = picture.alpha[16, 16]
    assert alpha == pytest.approx(1 - (1 - 102 / 255) ** 2, rel=1e-5)
    assert picture.alpha[0, 0] == 0 and np.isinf(picture.depth[0, 0])


def test_surroundings_and_opacity_are_the_callers():
    positions, indices, _ = plane(1)
    white = sheer.Scene.from_arrays(positions, indices)

    def middle(scene):
        return sheer.render(scene, "baseline", aa="none", size=(16, 9), background="none").colour[4, 8]

    bright, brighter, dark = (
        middle(white.with_environment("plain")),
        middle(white.with_environment("plain", strength=2.0)),
        middle(white.with_environment("none")),
    )
    np.testing.assert_allclose(brighter[:3], 2 * bright[:3], rtol=1e-5)
    np.testing.assert_array_equal(dark, [0, 0, 0, 1])
    np.testing.assert_allclose(middle(white.with_alpha(0.25))[3], 0.25, rtol=1e-6)


def test_the_view_of_a_scene_is_a_camera(pane):
    assert {"static", "path", "orbit"} <= set(pane.cameras)
    view = pane.pose("static")
    seen = [sheer.render(pane, "baseline", aa="none", size=(32, 18), camera=camera) for camera in ("static", view)]
    np.testing.assert_allclose(seen[0].depth, seen[1].depth, rtol=1e-4)
    assert pane.pose("path", 0.0).eye != pane.pose("path", 2.0).eye
    assert sheer.Camera(np.array([1, 2, 3]), [0, 0, 0]).eye == (1, 2, 3)
    assert sheer.Camera((1, 2, 3), ortho=4).ortho == 4 and sheer.Camera(fov=50).eye is None
    assert repr(sheer.Camera((1, 2, 3), (0, 0, 0), fov=90)) == "Camera(eye=(1, 2, 3), target=(0, 0, 0), fov=90)"
