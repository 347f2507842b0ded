//! `layers`: constant layers over a constant background. What a pixel has to be is known in closed form.

use glam::{Affine3A, Vec2, Vec3};
use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};
use sheer_scene::{
    Scene, SceneError,
    camera::{Camera, CameraKey, CameraMotion, ClipPlanes, Lens},
    environment::Environment,
    model::{AlphaMode, Material, ShadingModel},
};

use crate::{builder::SceneBuilder, rng::Rng, seed::SEED, shape::Model};

pub(crate) const PARAMETERS: &[ParameterInfo] = &[
    ParameterInfo {
        key: "count",
        default: "8",
        range: ParameterRange::Count(1, 64),
        what: "how many layers there are",
    },
    ParameterInfo {
        key: "alpha",
        default: "0.2",
        range: ParameterRange::Real(0.0, 1.0),
        what: "opacity of each layer",
    },
    ParameterInfo {
        key: "transmission",
        default: "0",
        range: ParameterRange::Real(0.0, 0.95),
        what: "share of the light that each layer transmits in its colour, as glass does; its opacity stays",
    },
    ParameterInfo {
        key: "colours",
        default: "white",
        range: ParameterRange::Choice(&LayerColours::WORDS),
        what: "white layers over grey, distinct hues over grey, red and green in turn over blue (ST Example 1), \
               or amber, blue and green in turn over grey, none of them bright",
    },
    ParameterInfo {
        key: "background",
        default: "0.0",
        range: ParameterRange::Real(0.0, 1.0),
        what: "linear grey behind the layers; with red-green, the strength of the blue",
    },
    ParameterInfo {
        key: "preset",
        default: "none",
        range: ParameterRange::Choice(&["none", "example-1", "example-2"]),
        what: "other defaults for the other keys: those of Example 1 or 2 of ST section 3.1; a key that is given wins",
    },
    SEED,
];

/// The defaults that a preset brings (ST section 3.1).
fn preset(word: &str) -> &'static [(&'static str, &'static str)] {
    match word {
        // Red over green over blue: (0.45, 0.2475, 0.3025).
        "example-1" => &[("count", "2"), ("alpha", "0.45"), ("colours", "red-green"), ("background", "1.0")],
        // Four sheets of white paper over grey: 0.7627.
        "example-2" => &[("count", "4"), ("alpha", "0.25"), ("colours", "white"), ("background", "0.25")],
        _ => &[],
    }
}

/// What colours the layers of the scene `layers` have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LayerColours {
    /// White over grey, as in Example 2 of ST section 3.1.
    White,
    /// Hues around the colour circle, red in front, over grey.
    Rainbow,
    /// Red, green, red… over blue, as in Example 1 of ST section 3.1.
    RedGreen,
    /// Amber, blue, green, amber… over grey: of stained glass, which takes something of every channel.
    Stained,
}

impl LayerColours {
    const WORDS: [&'static str; 4] = ["white", "rainbow", "red-green", "stained"];
    const STAINED: [Vec3; 3] =
        [Vec3::new(0.75, 0.5, 0.0), Vec3::new(0.0, 0.5, 0.75), Vec3::new(0.25, 0.75, 0.5)];

    /// The modes by their words on the command line.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        let modes = [Self::White, Self::Rainbow, Self::RedGreen, Self::Stained];
        Self::WORDS.iter().position(|known| *known == word).map(|at| modes[at])
    }

    /// Linear radiance of layer `index` of `count`, counted from the front.
    fn layer(self, index: u32, count: u32) -> Vec3 {
        match self {
            Self::White => Vec3::ONE,
            Self::Rainbow => {
                // Three cosines a third of a turn apart: saturated, of constant sum, and none is black.
                let turn = index as f32 / count as f32;
                Vec3::new(0.0, 1.0 / 3.0, 2.0 / 3.0)
                    .map(|offset| 0.5 + 0.5 * (std::f32::consts::TAU * (turn - offset)).cos())
            }
            Self::RedGreen => [Vec3::X, Vec3::Y][index as usize % 2],
            Self::Stained => Self::STAINED[index as usize % 3],
        }
    }

    fn background(self, strength: f32) -> Vec3 {
        if self == Self::RedGreen { Vec3::Z * strength } else { Vec3::splat(strength) }
    }
}

/// Linear radiance that every pixel of the scene `layers` has: with `a = alpha` and layer 0 in front,
/// `Σ a·(1-a)^i·colour_i + (1-a)^count·background` (STD Eq. 1, unrolled).
#[must_use]
pub fn layers_closed_form(count: u32, alpha: f32, colours: LayerColours, background: f32) -> Vec3 {
    glass_layers_closed_form(count, alpha, 0.0, colours, background)
}

/// The same for layers of glass: `Σ a·T_0…T_(i-1)·colour_i + T_0…T_(count-1)·background` with `T_i = 1 - a -
/// s·(1 - colour_i)` in red, green and blue; of the light that passes the opacity, `s = a·t / (1-t)` with `t
/// = transmission` takes on colour, all of it at most.
#[must_use]
pub fn glass_layers_closed_form(
    count: u32,
    alpha: f32,
    transmission: f32,
    colours: LayerColours,
    background: f32,
) -> Vec3 {
    let passes = 1.0 - alpha;
    let coloured = (alpha * transmission / (1.0 - transmission)).min(passes);
    let mut transmittance = Vec3::ONE;
    let mut sum = Vec3::ZERO;
    for index in 0..count {
        let colour = colours.layer(index, count);
        sum += transmittance * alpha * colour;
        transmittance *= passes - coloured * (Vec3::ONE - colour);
    }
    sum + transmittance * colours.background(background)
}

/// Wide enough for any picture of up to 32:1.
const HALF_EXTENT: Vec2 = Vec2::new(32.0, 2.0);
/// Distance of neighbouring layers, metres; small steps keep the deepest of 64 layers near.
const SPACING: f32 = 0.25;

pub(crate) fn build(values: &Values) -> Result<Scene, SceneError> {
    let values = values.clone().with_defaults(preset(values.text("preset")));
    let (count, alpha) = (values.count("count"), values.real("alpha"));
    let transmission = values.real("transmission");
    let colours = LayerColours::from_word(values.text("colours")).expect("checked against its range");
    let mut builder = SceneBuilder::new("layers", Environment::black());

    // Stored in shuffled order: a method that composites right does not live on the order of the list.
    let mut order: Vec<u32> = (0..count).collect();
    Rng::new(values.count(SEED.key), "layers").shuffle(&mut order);
    for index in order {
        let layer = Material {
            name: format!("layer {index}"),
            model: ShadingModel::Luminous,
            base_colour: colours.layer(index, count).extend(alpha),
            alpha_mode: AlphaMode::Blend,
            transmission,
            ..Material::default()
        };
        put_sheet(&mut builder, layer, -(index as f32) * SPACING);
    }
    let behind = Material {
        name: "background".to_owned(),
        model: ShadingModel::Luminous,
        base_colour: colours.background(values.real("background")).extend(1.0),
        ..Material::default()
    };
    put_sheet(&mut builder, behind, -(count as f32) * SPACING);

    let key = CameraKey { time_secs: 0.0, eye: Vec3::Z, target: Vec3::ZERO };
    builder.camera(Camera {
        name: "static".to_owned(),
        lens: Lens::Orthographic { half_height: 1.0 },
        clip: ClipPlanes::NONE,
        motion: CameraMotion::Path { keys: vec![key] },
    });
    builder.finish()
}

fn put_sheet(builder: &mut SceneBuilder, material: Material, depth: f32) {
    let name = material.name.clone();
    let material = builder.material(material);
    let mut model = Model::default();
    model.paint(material, Vec3::ONE).panel(
        -HALF_EXTENT.extend(0.0),
        Vec3::X * 2.0 * HALF_EXTENT.x,
        Vec3::Y * 2.0 * HALF_EXTENT.y,
    );
    let prop = builder.prop(&name, model);
    builder.place(&prop, Affine3A::from_translation(Vec3::Z * depth));
}

#[cfg(test)]
mod tests {
    use sheer_core::colour::{Premul, Straight};

    use super::*;
    use crate::catalogue;

    /// Colour and opacity of every sheet of the scene, from the back to the front.
    fn sheets(text: &str) -> Vec<Straight> {
        let scene = catalogue::build(text).unwrap();
        let mut sheets: Vec<(f32, Straight)> = Vec::new();
        for instance in &scene.parts().instances {
            let depth = scene.parts().nodes[instance.node as usize].transform.to_affine().translation.z;
            let mesh = &scene.parts().meshes[instance.mesh as usize];
            sheets.push((depth, scene.parts().materials[mesh.material as usize].base_colour.into()));
        }
        sheets.sort_by(|a, b| a.0.total_cmp(&b.0));
        sheets.into_iter().map(|(_, sheet)| sheet).collect()
    }

    fn composited(sheets: &[Straight]) -> Premul {
        sheets.iter().fold(Premul::CLEAR, |back, sheet| sheet.to_premul().over(back))
    }

    #[test]
    fn the_closed_form_is_what_over_gives_for_the_layers_of_the_scene() {
        for (text, colours) in [
            ("layers:count=1,alpha=0.7", LayerColours::White),
            ("layers:count=8,alpha=0.2,background=0.3", LayerColours::White),
            ("layers:count=21,alpha=0.1,background=0.8,colours=rainbow,seed=4", LayerColours::Rainbow),
            ("layers:count=2,alpha=0.45,background=1,colours=red-green", LayerColours::RedGreen),
        ] {
            let sheets = sheets(text);
            let over = composited(&sheets);
            let count = sheets.len() as u32 - 1;
            let closed = layers_closed_form(count, sheets[1].alpha, colours, sheets[0].rgb.z);
            assert!((over.rgb - closed).abs().max_element() < 1e-5, "{text}: {over:?} {closed}");
            assert!((over.alpha - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn the_presets_are_the_papers_examples() {
        let first = composited(&sheets("layers:preset=example-1,seed=5"));
        assert!((first.rgb - Vec3::new(0.45, 0.2475, 0.3025)).abs().max_element() < 1e-6, "{first:?}");
        let second = composited(&sheets("layers:preset=example-2"));
        // The paper prints four digits.
        assert!((second.rgb - Vec3::splat(0.7627)).abs().max_element() < 5e-5, "{second:?}");
        // Negative control: without a preset the scene is another one.
        assert_ne!(sheets("layers:preset=none").len(), sheets("layers:preset=example-2").len());
    }

    #[test]
    fn glass_filters_what_is_behind_it_and_no_transmission_is_no_glass() {
        // 0.5 amber and what 0.5 of white becomes: a quarter keeps its colour, a quarter is filtered.
        let one = glass_layers_closed_form(1, 0.5, 1.0 / 3.0, LayerColours::Stained, 1.0);
        assert!(one.abs_diff_eq(Vec3::new(0.8125, 0.625, 0.25), 1e-6), "{one}");
        // All of it is filtered, and amber before blue is nearly black.
        let two = glass_layers_closed_form(2, 0.1, 0.95, LayerColours::Stained, 1.0);
        assert!(two.x < 0.1 && two.z < 0.1 && two.y > 0.2, "{two}");
        let without = glass_layers_closed_form(3, 0.2, 0.0, LayerColours::Rainbow, 0.4);
        assert_eq!(without, layers_closed_form(3, 0.2, LayerColours::Rainbow, 0.4));
    }

    #[test]
    fn a_key_that_is_given_wins_over_the_preset_wherever_it_stands() {
        for text in ["layers:alpha=0.3,preset=example-1", "layers:preset=example-1,alpha=0.3"] {
            let over = composited(&sheets(text));
            let closed = layers_closed_form(2, 0.3, LayerColours::RedGreen, 1.0);
            assert!((over.rgb - closed).abs().max_element() < 1e-6, "{text}: {over:?} {closed}");
        }
    }

    #[test]
    fn the_closed_form_gives_the_papers_examples() {
        let first = layers_closed_form(2, 0.45, LayerColours::RedGreen, 1.0);
        assert!((first - Vec3::new(0.45, 0.2475, 0.3025)).abs().max_element() < 1e-6, "{first}");
        let second = layers_closed_form(4, 0.25, LayerColours::White, 0.25);
        assert!((second - Vec3::splat(0.7627)).abs().max_element() < 1e-4, "{second}");
        // Negative control: the order of the layers matters.
        assert!((first.x - first.y).abs() > 0.1);
    }
}
