//! Scenes: opened, or made of arrays.

use std::{
    ffi::CString,
    path::{Path, PathBuf},
    sync::Arc,
};

use glam::{Vec3, Vec4};
use pyo3::{
    exceptions::{PyTypeError, PyValueError},
    prelude::*,
    pybacked::PyBackedBytes,
    types::PyString,
};
use sheer_core::{colour::linear_from_srgb, suggestion::suggestion, text::MemorySize};
use sheer_image::{TextureLimits, read_panorama, unit_from_u8};
use sheer_load::{LoadOptions, Loaded};
use sheer_render::limits::MOST_STRENGTH;
use sheer_scene::{Environment, FrameSize, Scene, environment::NAMED, model::Mesh};

use crate::{
    camera::{PyCamera, camera_choice},
    error::{Raise as _, SheerWarning, unlocked},
    pixels::{Numbers, array_of, in_order},
};

type Triple = (f32, f32, f32);

/// A scene that has been checked once and does not change: what to render, from where, under which light.
#[pyclass(name = "Scene", module = "sheer", frozen)]
#[derive(Clone, Debug)]
pub(crate) struct PyScene {
    scene: Arc<Scene>,
    /// As it was asked for.
    text: String,
    warnings: Vec<String>,
}

/// Opens a scene.
///
/// source: the name of a built-in scene, alone or with parameters as in "layers:count=8,alpha=0.2"
/// (`scenes()` lists them); the path of a .gltf, .glb, .obj, .ply, .stl or .hair file; or the bytes of such a
/// file, as other libraries export them.
/// name: what bytes are called in messages; its ending says which format they have where they do not say so
/// themselves (.obj), and files that they refer to are looked for beside it.
/// strict: a part of the file that is broken is an error; otherwise what is sound is shown, and the rest is a
/// SheerWarning.
/// allowed_folders: folders besides the file's own that the files it refers to may lie in.
/// clip: the animation to play, by its name or number; all that do not get in each other's way if not given,
/// "none" for everything at rest.
/// scene, variant: which of a file's scenes and variants of materials, by name or number.
/// memory_limit: what the scene may take of memory, bytes.
///
/// Raises ValueError where there is no such scene, clip or variant, FileNotFoundError or another OSError
/// where a file cannot be read, SheerError with file and place where it is broken.
#[pyfunction]
#[pyo3(signature = (source, *, name=None, strict=false, allowed_folders=None, clip=None, scene=None, variant=None, memory_limit=None))]
#[expect(clippy::too_many_arguments, reason = "they are keywords to whoever calls this")]
pub(crate) fn open(
    source: &Bound<'_, PyAny>,
    name: Option<String>,
    strict: bool,
    allowed_folders: Option<Vec<PathBuf>>,
    clip: Option<String>,
    scene: Option<String>,
    variant: Option<String>,
    memory_limit: Option<u64>,
) -> PyResult<PyScene> {
    let allowed_folders = allowed_folders.unwrap_or_default();
    let memory_limit = memory_limit.map(MemorySize);
    let options = LoadOptions { strict, allowed_folders, memory_limit, clip, scene, variant };
    open_with(source, name, &options)
}

fn open_with(source: &Bound<'_, PyAny>, name: Option<String>, options: &LoadOptions) -> PyResult<PyScene> {
    let py = source.py();
    if let Ok(bytes) = source.extract::<PyBackedBytes>() {
        let text = name.unwrap_or_else(|| "bytes".to_owned());
        let read = || sheer_load::read(&bytes, Path::new(&text), options).map_err(|error| error.raise());
        let loaded = unlocked(py, read)?;
        return PyScene::of_loaded(py, text, loaded);
    }
    if name.is_some() {
        let problem = "name is for bytes: a file and a built-in scene have one already";
        return Err(PyValueError::new_err(problem));
    }
    if let Ok(text) = source.cast::<PyString>() {
        let text = text.to_string();
        let open = || sheer_gallery::open_with(&text, options).map_err(|error| error.raise());
        let loaded = unlocked(py, open)?;
        return PyScene::of_loaded(py, text, loaded);
    }
    let Ok(path) = source.extract::<PathBuf>() else {
        let problem = "give the name of a built-in scene, the path of a file, or the bytes of one";
        return Err(PyTypeError::new_err(problem));
    };
    let loaded = unlocked(py, || sheer_load::open_with(&path, options).map_err(|error| error.raise()))?;
    PyScene::of_loaded(py, path.display().to_string(), loaded)
}

/// The names of the built-in scenes.
#[pyfunction]
pub(crate) fn scenes() -> Vec<&'static str> {
    sheer_gallery::catalogue().iter().map(|scene| scene.name).collect()
}

#[pymethods]
impl PyScene {
    /// Makes a scene of triangles.
    ///
    /// positions: of the vertices, an array of shape (vertices, 3), world space (right-handed, +Y up).
    /// indices: of the vertices of each triangle, integers of shape (triangles, 3), counter-clockwise seen
    /// from the front; without them each three vertices are a triangle.
    /// rgba: colour and opacity, one of shape (4,) or one a vertex, (vertices, 4): floats are linear from 0
    /// to 1, bytes (uint8) are sRGB; alpha is straight. White if not given.
    /// normals: of the vertices, shape (vertices, 3), of any length; triangles are flat without them.
    /// name: what reports call the scene.
    ///
    /// It is lit by the neutral surroundings in which files without lights are shown, see with_environment.
    /// Arrays are copied once, and checked: what is wrong raises ValueError or TypeError.
    #[staticmethod]
    #[pyo3(signature = (positions, indices=None, rgba=None, *, normals=None, name="arrays"))]
    fn from_arrays(
        positions: &Bound<'_, PyAny>,
        indices: Option<&Bound<'_, PyAny>>,
        rgba: Option<&Bound<'_, PyAny>>,
        normals: Option<&Bound<'_, PyAny>>,
        name: &str,
    ) -> PyResult<Self> {
        let py = positions.py();
        let positions = vectors(positions, "positions")?;
        let indices = match indices {
            Some(indices) => triangles(indices)?,
            None => in_threes(positions.len())?,
        };
        let (base_colour, colours) = match rgba {
            Some(rgba) => rgba_of(rgba, positions.len())?,
            None => (Vec4::ONE, Vec::new()),
        };
        let normals = normals.map(|normals| vectors(normals, "normals")).transpose()?.unwrap_or_default();
        let text = name.to_owned();
        let scene = unlocked(py, || {
            let normals = normals.iter().map(|normal| normal.try_normalize().unwrap_or(Vec3::Y)).collect();
            let mesh = Mesh { name: text.clone(), positions, normals, colours, indices, ..Mesh::default() };
            sheer_load::scene_of_mesh(&text, mesh, base_colour).map_err(|error| error.raise())
        })?;
        Ok(Self { scene: Arc::new(scene), text, warnings: Vec::new() })
    }

    /// What reports call the scene.
    #[getter]
    fn name(&self) -> &str {
        self.scene.name()
    }

    /// What the file shows differently from what its author meant, a text each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// The names that `camera` may have.
    #[getter]
    fn cameras(&self) -> Vec<String> {
        let mut names: Vec<String> =
            self.scene.parts().cameras.iter().map(|camera| camera.name.clone()).collect();
        for common in ["static", "orbit"] {
            if !names.iter().any(|name| name == common) {
                names.push(common.to_owned());
            }
        }
        names
    }

    /// Lowest and highest corner of a box around everything at rest, world space.
    #[getter]
    fn bounds(&self) -> (Triple, Triple) {
        let [low, high] = self.scene.bounds();
        (low.into(), high.into())
    }

    /// How many triangles a frame has, those of all instances.
    #[getter]
    fn triangle_count(&self) -> u64 {
        FrameSize::of(self.scene.parts()).triangles
    }

    /// What tells the contents of the scene apart, as `scene_hash` in the reports of the command line.
    fn content_hash(&self, py: Python<'_>) -> String {
        py.detach(|| format!("{:016x}", self.scene.content_hash()))
    }

    /// Where a camera is at a time: None for the default one, or the name of one.
    ///
    /// Raises ValueError where there is no such camera.
    #[pyo3(signature = (camera=None, time=0.0))]
    fn pose(&self, camera: Option<&Bound<'_, PyAny>>, time: f32) -> PyResult<PyCamera> {
        let choice = camera_choice(camera, &self.scene)?;
        let camera = self.scene.camera(&choice).map_err(|error| error.raise())?;
        Ok(PyCamera::of_pose(&self.scene.pose(&camera, time)))
    }

    /// The same scene with the opacity of every material set to alpha, 0 to 1; alpha in textures stays.
    fn with_alpha(&self, alpha: f32) -> PyResult<Self> {
        if !(0.0..=1.0).contains(&alpha) {
            return Err(PyValueError::new_err(format!("alpha is {alpha}: give a number from 0 to 1")));
        }
        Ok(Self { scene: Arc::new((*self.scene).clone().with_alpha(alpha)), ..self.clone() })
    }

    /// The same scene in other surroundings: "none", "studio", "plain", or the path of a panorama (.hdr or
    /// .exr, twice as wide as high), `strength` times as bright.
    #[pyo3(signature = (environment, strength=1.0))]
    fn with_environment(&self, environment: &Bound<'_, PyAny>, strength: f32) -> PyResult<Self> {
        if !(0.0..=MOST_STRENGTH).contains(&strength) {
            let problem = format!("strength is {strength}: give a number from 0 to {MOST_STRENGTH}");
            return Err(PyValueError::new_err(problem));
        }
        let environment = environment_of(environment)?.scaled(strength);
        Ok(Self { scene: Arc::new((*self.scene).clone().with_environment(environment)), ..self.clone() })
    }

    fn __repr__(&self) -> String {
        format!("<sheer.Scene {:?}, {} triangles>", self.text, self.triangle_count())
    }
}

impl PyScene {
    fn of_loaded(py: Python<'_>, text: String, loaded: Loaded) -> PyResult<Self> {
        let warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
        warnings.iter().try_for_each(|warning| warn(py, &format!("{text}: {warning}")))?;
        Ok(Self { scene: Arc::new(loaded.scene), text, warnings })
    }

    /// Any source, opened, or a scene as it is.
    pub(crate) fn of_any(source: &Bound<'_, PyAny>) -> PyResult<Self> {
        match source.cast::<Self>() {
            Ok(scene) => Ok(scene.get().clone()),
            Err(_) => open_with(source, None, &LoadOptions::default()),
        }
    }

    /// As it was asked for.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// The scene for pictures of `size` pixels: where it has no camera, a view of that shape is made up.
    pub(crate) fn framed_for(&self, size: [u32; 2]) -> Arc<Scene> {
        if self.scene.parts().cameras.is_empty() {
            Arc::new((*self.scene).clone().framed_for(size))
        } else {
            Arc::clone(&self.scene)
        }
    }
}

/// Warns, as a Python program does.
pub(crate) fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    // What a file calls its parts may have any characters.
    let text = CString::new(text.replace('\0', "")).unwrap_or_default();
    PyErr::warn(py, &py.get_type::<SheerWarning>(), &text, 1)
}

fn environment_of(environment: &Bound<'_, PyAny>) -> PyResult<Environment> {
    let path: PathBuf = environment.extract()?;
    let text = path.to_string_lossy();
    if let Some(named) = NAMED.iter().find(|named| named.name == text) {
        return Ok((named.make)());
    }
    let is_panorama = path.extension().is_some_and(|extension| {
        extension.eq_ignore_ascii_case("hdr") || extension.eq_ignore_ascii_case("exr")
    });
    if !is_panorama {
        let names = NAMED.map(|named| named.name);
        return Err(PyValueError::new_err(format!(
            "there are no surroundings {text:?}; there are {} and .hdr and .exr files{}",
            names.join(", "),
            suggestion(&text, names)
        )));
    }
    unlocked(environment.py(), || {
        let panorama = read_panorama(&path, TextureLimits::default()).map_err(|error| error.raise())?;
        Environment::from_panorama(&panorama).map_err(|error| error.raise())
    })
}

fn wrong_shape(what: &str, shape: &[usize], wanted: &str) -> PyErr {
    PyValueError::new_err(format!("{what}: its shape is {shape:?}; give {wanted}"))
}

/// Vectors, one a vertex.
fn vectors(object: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<Vec3>> {
    let (array, shape, _) = array_of(object, what)?;
    let [_, 3] = shape[..] else { return Err(wrong_shape(what, &shape, "(vertices, 3)")) };
    let numbers = in_order::<f32>(&array, "float32")?;
    Ok(numbers.as_slice()?.as_chunks::<3>().0.iter().copied().map(Vec3::from).collect())
}

/// Indices, three a triangle.
fn triangles(object: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 3]>> {
    let (array, shape, numbers) = array_of(object, "indices")?;
    let [_, 3] = shape[..] else { return Err(wrong_shape("indices", &shape, "(triangles, 3)")) };
    if numbers == Numbers::Floats {
        return Err(PyTypeError::new_err("indices: give integers"));
    }
    // Through 64 bits, so that a negative or enormous index does not become one that is there.
    let wide = in_order::<i64>(&array, "int64")?;
    let narrow = |corners: &[i64; 3]| {
        let [a, b, c] = corners.map(u32::try_from);
        Some([a.ok()?, b.ok()?, c.ok()?])
    };
    let triangles = wide.as_slice()?.as_chunks::<3>().0;
    triangles
        .iter()
        .enumerate()
        .map(|(at, corners)| {
            narrow(corners).ok_or_else(|| {
                PyValueError::new_err(format!(
                    "indices[{at}] is {corners:?}: an index is below 0 or above 32 bits"
                ))
            })
        })
        .collect()
}

/// The triangles of vertices that are no others'.
fn in_threes(vertices: usize) -> PyResult<Vec<[u32; 3]>> {
    match u32::try_from(vertices) {
        Ok(count) if count.is_multiple_of(3) => {
            Ok((0..count / 3).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect())
        }
        _ => Err(PyValueError::new_err(format!("{vertices} positions are no triangles without indices"))),
    }
}

/// Linear straight colour: of all, and of each of so many vertices.
fn rgba_of(object: &Bound<'_, PyAny>, vertices: usize) -> PyResult<(Vec4, Vec<Vec4>)> {
    let (array, shape, numbers) = array_of(object, "rgba")?;
    let per_vertex = match shape[..] {
        [4] => false,
        [count, 4] if count == vertices => true,
        _ => {
            let wanted = format!("(4,) or ({vertices}, 4), one a vertex");
            return Err(wrong_shape("rgba", &shape, &wanted));
        }
    };
    let colours: Vec<Vec4> = match numbers {
        Numbers::Floats => {
            let floats = in_order::<f32>(&array, "float32")?;
            floats.as_slice()?.as_chunks::<4>().0.iter().copied().map(Vec4::from).collect()
        }
        Numbers::Bytes => {
            let bytes = in_order::<u8>(&array, "uint8")?;
            let linear = |&[r, g, b, alpha]: &[u8; 4]| {
                let [r, g, b] = [r, g, b].map(|value| linear_from_srgb(unit_from_u8(value)));
                Vec4::new(r, g, b, unit_from_u8(alpha))
            };
            bytes.as_slice()?.as_chunks::<4>().0.iter().map(linear).collect()
        }
        Numbers::Integers => {
            return Err(PyTypeError::new_err("rgba: give floats, linear from 0 to 1, or uint8, sRGB"));
        }
    };
    let is_colour = |colour: &Vec4| colour.cmpge(Vec4::ZERO).all() && colour.cmple(Vec4::ONE).all();
    if let Some(at) = colours.iter().position(|colour| !is_colour(colour)) {
        let place = if per_vertex { format!("rgba[{at}]") } else { "rgba".to_owned() };
        let [r, g, b, alpha] = colours[at].to_array();
        let problem = format!("{place} is ({r}, {g}, {b}, {alpha}): give numbers from 0 to 1, linear");
        return Err(PyValueError::new_err(problem));
    }
    if per_vertex { Ok((Vec4::ONE, colours)) } else { Ok((colours[0], Vec::new())) }
}
