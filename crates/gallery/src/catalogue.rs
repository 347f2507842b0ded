//! The catalogue: what built-in scenes there are, and how one is built from its text.

use sheer_core::{
    parameter::{ParameterInfo, Values, split_name},
    suggestion::suggestion,
};
use sheer_scene::{Scene, SceneError};

use crate::{
    error::GalleryError,
    scene::{arena, calibration, hairball, layers, motor, pane, plume, smoke_square, windy_hill},
};

/// What there is to know about a built-in scene.
#[derive(Debug)]
pub struct BuiltinInfo {
    /// The word on the command line.
    pub name: &'static str,
    /// One line on what it shows.
    pub title: &'static str,
    /// The figure or section of a paper that it is made after.
    pub source: &'static str,
    /// What can be set, `seed` last.
    pub parameters: &'static [ParameterInfo],
    build: fn(&Values) -> Result<Scene, SceneError>,
}

/// All built-in scenes, in the order in which `sheer scenes` lists them.
#[must_use]
pub fn catalogue() -> &'static [BuiltinInfo] {
    &[
        BuiltinInfo {
            name: "smoke-square",
            title: "a town square in late light; the camera passes through a drifting cloud of smoke",
            source: "STD Fig. 9 and 12",
            parameters: smoke_square::PARAMETERS,
            build: smoke_square::build,
        },
        BuiltinInfo {
            name: "pane",
            title: "one transparent pane in the town square",
            source: "STD Fig. 6 and 7",
            parameters: pane::PARAMETERS,
            build: pane::build,
        },
        BuiltinInfo {
            name: "calibration",
            title: "ten opacity levels over black, each above the opaque grey of the same value",
            source: "STD Fig. 2",
            parameters: calibration::PARAMETERS,
            build: calibration::build,
        },
        BuiltinInfo {
            name: "layers",
            title: "constant layers over a constant background, with a closed-form answer",
            source: "ST section 3.1",
            parameters: layers::PARAMETERS,
            build: layers::build,
        },
        BuiltinInfo {
            name: "plume",
            title: "a plume of smoke particles rising from a fire bowl",
            source: "ST Fig. 8",
            parameters: plume::PARAMETERS,
            build: plume::build,
        },
        BuiltinInfo {
            name: "motor",
            title: "a glassy CAD model of a V engine at work, transparent all over",
            source: "ST Fig. 2 and 4",
            parameters: motor::PARAMETERS,
            build: motor::build,
        },
        BuiltinInfo {
            name: "hairball",
            title: "a sitting puppy under 300,000 transparent hairs",
            source: "ST Fig. 7",
            parameters: hairball::PARAMETERS,
            build: hairball::build,
        },
        BuiltinInfo {
            name: "windy-hill",
            title: "a girl on a hill in the wind: hairs, grass cards and cloth, all transparent, shadow one another",
            source: "ST Fig. 1",
            parameters: windy_hill::PARAMETERS,
            build: windy_hill::build,
        },
        BuiltinInfo {
            name: "arena",
            title: "a fight in a ring of stone at dusk: shields, barriers, fire, drops and dust; the effects rise and fall",
            source: "STD Fig. 1, 8 and 11",
            parameters: arena::PARAMETERS,
            build: arena::build,
        },
    ]
}

/// Whether a text begins with the name of a built-in scene, whatever its parameters are.
pub(crate) fn is_builtin(text: &str) -> bool {
    let (name, _) = split_name(text);
    catalogue().iter().any(|info| info.name == name)
}

/// What to say of a text that no scene has for its name.
pub(crate) fn unknown(text: &str) -> GalleryError {
    let suggestion = suggestion(split_name(text).0, catalogue().iter().map(|info| info.name));
    GalleryError::Unknown { text: text.to_owned(), suggestion }
}

/// Builds a scene from `name` or `name:key=value,key=value`.
///
/// # Errors
/// [`GalleryError::Unknown`] if no scene has that name; [`GalleryError::Parameter`] with what is allowed if a
/// key or a value is off.
pub fn build(text: &str) -> Result<Scene, GalleryError> {
    let (name, settings) = split_name(text);
    let info = catalogue().iter().find(|info| info.name == name).ok_or_else(|| unknown(text))?;
    let values = Values::parse(info.parameters, settings)
        .map_err(|problem| GalleryError::Parameter { scene: info.name.to_owned(), problem })?;
    Ok((info.build)(&values)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::SEED;

    /// Few enough of everything that a test takes little time; the rest as it stands.
    fn light(info: &BuiltinInfo) -> String {
        let few = [("particles", "500"), ("hairs", "700"), ("cards", "100"), ("effects", "0.2")];
        let taken =
            few.iter().filter(|(key, _)| info.parameters.iter().any(|parameter| parameter.key == *key));
        taken.fold(format!("{}:", info.name), |text, (key, value)| format!("{text}{key}={value},"))
    }

    /// Everything that a seed may change, as text.
    fn fingerprint(scene: &Scene) -> u64 {
        let parts = scene.parts();
        let meshes = parts.meshes.iter().flat_map(|mesh| mesh.positions.iter().flat_map(|p| p.to_array()));
        let colours = parts.materials.iter().flat_map(|material| material.base_colour.to_array());
        let particles = parts.particles.iter().flat_map(|system| &system.particles);
        let motion = particles.flat_map(|particle| [particle.origin.x, particle.velocity.y, particle.alpha]);
        let places = parts.nodes.iter().flat_map(|node| node.transform.to_affine().to_cols_array());
        let numbers = meshes.chain(colours).chain(motion).chain(places).flat_map(f32::to_le_bytes);
        let texels =
            parts.textures.iter().flat_map(|texture| texture.image.as_slice().iter().flatten().copied());
        sheer_core::hash::fnv1a(numbers.chain(texels))
    }

    #[test]
    fn every_scene_of_the_catalogue_builds_with_its_defaults() {
        for info in catalogue() {
            let scene = build(info.name).unwrap();
            assert_eq!(scene.name(), info.name);
            assert_eq!(scene.parts().cameras.iter().filter(|camera| camera.name == "static").count(), 1);
            assert_eq!(info.parameters.last(), Some(&SEED), "{}", info.name);
            for parameter in info.parameters {
                assert!(parameter.range.holds(parameter.default), "{} {}", info.name, parameter.key);
            }
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_scene_and_another_seed_another() {
        let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        // The ten levels are what they are; nothing in them is left to chance.
        for info in catalogue().iter().filter(|info| info.name != "calibration") {
            let text = light(info);
            let first = fingerprint(&build(&format!("{text}seed=3")).unwrap());
            let again = one_thread.install(|| fingerprint(&build(&format!("{text}seed=3")).unwrap()));
            assert_eq!(first, again, "{}: not even the number of threads may matter", info.name);
            assert_ne!(first, fingerprint(&build(&format!("{text}seed=4")).unwrap()), "{}", info.name);
        }
    }

    #[test]
    fn wrong_parameters_are_refused_with_what_is_allowed() {
        assert!(matches!(build("smoke"), Err(GalleryError::Unknown { text, .. }) if text == "smoke"));
        for (text, says) in [
            ("layers:count=0", "count=0 is not in 1..=64"),
            ("layers:alpha=1.5", "0.0..=1.0"),
            ("layers:alpha=nan", "0.0..=1.0"),
            ("layers:colours=grey", "white|rainbow|red-green"),
            ("layers:depth=3", "there is no parameter 'depth'; it takes count (1..=64)"),
            ("layers:count", "'count' is not KEY=VALUE"),
            ("layers:count=2,count=3", "count is given twice"),
            ("calibration:seed=-1", "seed=-1"),
        ] {
            let error = build(text).unwrap_err();
            assert!(matches!(error, GalleryError::Parameter { .. }), "{error}");
            assert!(error.to_string().contains(says), "{text}: {error}");
        }
    }
}
