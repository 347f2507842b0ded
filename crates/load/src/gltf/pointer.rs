//! What the JSON pointers of `KHR_animation_pointer` mean here.

use sheer_scene::model::{Factor, LensNumber, LightNumber, TextureSlot};

use super::{
    document::Document,
    schema::{AnimationTarget, Index},
};

/// What an animation changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pointed<'p> {
    /// `translation`, `rotation`, `scale` or `weights`.
    Node {
        node: Index,
        path: &'p str,
    },
    Visibility {
        node: Index,
    },
    BaseColour {
        material: Index,
    },
    EmissiveFactor {
        material: Index,
    },
    EmissiveStrength {
        material: Index,
    },
    Factor {
        material: Index,
        which: Factor,
    },
    Lens {
        camera: Index,
        which: LensNumber,
    },
    /// Part of a `KHR_texture_transform`: `offset`, `rotation` or `scale`.
    TextureTransform {
        material: Index,
        slot: TextureSlot,
        part: &'p str,
    },
    LightColour {
        light: Index,
    },
    LightIntensity {
        light: Index,
    },
    LightShape {
        light: Index,
        which: LightNumber,
    },
    Transmission {
        material: Index,
    },
}

/// The pointer of a channel's target; those of the core are written as one. None if it has no target.
pub(super) fn of_target(target: &AnimationTarget) -> Option<String> {
    match (&target.extensions.pointer, target.node) {
        (Some(given), _) if target.path == "pointer" => Some(given.pointer.clone()),
        (_, Some(node)) => Some(format!("/nodes/{node}/{}", target.path)),
        (_, None) => None,
    }
}

/// What a pointer means; none for what cannot be animated here.
pub(super) fn parse(pointer: &str) -> Option<Pointed<'_>> {
    let mut steps = pointer.strip_prefix('/')?.split('/');
    let root = steps.next()?;
    if root == "extensions" {
        let (extension, list) = (steps.next()?, steps.next()?);
        let light = steps.next()?.parse().ok()?;
        let rest: Vec<&str> = steps.collect();
        if (extension, list) != ("KHR_lights_punctual", "lights") {
            return None;
        }
        let shape = |which| Some(Pointed::LightShape { light, which });
        return match &rest[..] {
            ["color"] => Some(Pointed::LightColour { light }),
            ["intensity"] => Some(Pointed::LightIntensity { light }),
            ["range"] => shape(LightNumber::Range),
            ["spot", "innerConeAngle"] => shape(LightNumber::InnerCone),
            ["spot", "outerConeAngle"] => shape(LightNumber::OuterCone),
            _ => None,
        };
    }
    let index = steps.next()?.parse().ok()?;
    let rest: Vec<&str> = steps.collect();
    match root {
        "nodes" => match rest[..] {
            [path @ ("translation" | "rotation" | "scale" | "weights")] => {
                Some(Pointed::Node { node: index, path })
            }
            ["extensions", "KHR_node_visibility", "visible"] => Some(Pointed::Visibility { node: index }),
            _ => None,
        },
        "cameras" => {
            let which = match rest[..] {
                ["perspective", "yfov"] => LensNumber::FieldOfView,
                ["orthographic", "ymag"] => LensNumber::HalfHeight,
                ["perspective" | "orthographic", "znear"] => LensNumber::Near,
                ["perspective" | "orthographic", "zfar"] => LensNumber::Far,
                _ => return None,
            };
            Some(Pointed::Lens { camera: index, which })
        }
        "materials" => of_material(index, &rest),
        _ => None,
    }
}

fn of_material<'p>(material: Index, path: &[&'p str]) -> Option<Pointed<'p>> {
    let factor = |which| Some(Pointed::Factor { material, which });
    match path {
        ["pbrMetallicRoughness", "baseColorFactor"] => Some(Pointed::BaseColour { material }),
        ["pbrMetallicRoughness", "metallicFactor"] => factor(Factor::Metallic),
        ["pbrMetallicRoughness", "roughnessFactor"] => factor(Factor::Roughness),
        ["alphaCutoff"] => factor(Factor::AlphaCutoff),
        ["normalTexture", "scale"] => factor(Factor::NormalScale),
        ["occlusionTexture", "strength"] => factor(Factor::OcclusionStrength),
        ["emissiveFactor"] => Some(Pointed::EmissiveFactor { material }),
        ["extensions", "KHR_materials_emissive_strength", "emissiveStrength"] => {
            Some(Pointed::EmissiveStrength { material })
        }
        ["extensions", "KHR_materials_transmission", "transmissionFactor"] => {
            Some(Pointed::Transmission { material })
        }
        [texture @ .., "extensions", "KHR_texture_transform", part @ ("offset" | "rotation" | "scale")] => {
            let slot = match texture {
                ["pbrMetallicRoughness", "baseColorTexture"] => TextureSlot::BaseColour,
                ["pbrMetallicRoughness", "metallicRoughnessTexture"] => TextureSlot::MetallicRoughness,
                ["normalTexture"] => TextureSlot::Normal,
                ["occlusionTexture"] => TextureSlot::Occlusion,
                ["emissiveTexture"] => TextureSlot::Emissive,
                _ => return None,
            };
            Some(Pointed::TextureTransform { material, slot, part })
        }
        _ => None,
    }
}

/// The targets of the animations that may play, as pointers.
fn playing<'d>(document: &'d Document<'_>) -> impl Iterator<Item = String> + 'd {
    let animations = document.root.animations.iter().enumerate();
    let playing = animations.filter(|(index, _)| document.choices.plays(*index));
    let channels = playing.flat_map(|(_, animation)| &animation.channels);
    channels.filter_map(|channel| of_target(&channel.target))
}

/// The nodes whose visibility an animation changes that may play.
pub(super) fn animated_visibilities<'d>(document: &'d Document<'_>) -> impl Iterator<Item = Index> + 'd {
    playing(document).filter_map(|pointer| match parse(&pointer)? {
        Pointed::Visibility { node } => Some(node),
        _ => None,
    })
}

/// The materials whose transmission an animation changes that may play.
pub(super) fn animated_transmissions<'d>(document: &'d Document<'_>) -> impl Iterator<Item = Index> + 'd {
    playing(document).filter_map(|pointer| match parse(&pointer)? {
        Pointed::Transmission { material } => Some(material),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pointers_are_understood_as_far_as_they_have_an_effect() {
        assert_eq!(parse("/nodes/3/scale"), Some(Pointed::Node { node: 3, path: "scale" }));
        assert_eq!(
            parse(
                "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset"
            ),
            Some(Pointed::TextureTransform { material: 0, slot: TextureSlot::BaseColour, part: "offset" })
        );
        assert_eq!(
            parse("/extensions/KHR_lights_punctual/lights/2/intensity"),
            Some(Pointed::LightIntensity { light: 2 })
        );
        assert_eq!(
            parse("/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle"),
            Some(Pointed::LightShape { light: 0, which: LightNumber::OuterCone })
        );
        for nothing in [
            "",
            "/",
            "nodes/0/scale",
            "/nodes/-1/scale",
            "/nodes/0/scale/0",
            "/materials/0",
            "/cameras/0/perspective/aspectRatio",
            "/extensions/KHR_lights_punctual/lights/0/spot",
            "/extensions/KHR_lights_punctual/lights/0/type",
        ] {
            assert_eq!(parse(nothing), None, "{nothing}");
        }
    }
}
