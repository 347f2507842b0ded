//! Which scene, clip and variant of a file is shown.

use std::path::Path;

use super::schema::{Index, Primitive, Root};
use crate::{LoadError, LoadOptions, chosen};

/// What is chosen, by index.
pub(super) struct Choices {
    /// None: the file's own choice.
    pub scene: Option<Index>,
    pub clip: ClipChoice,
    /// None: materials as they are without a variant.
    pub variant: Option<Index>,
}

/// Which animations play.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ClipChoice {
    /// All that do not get in each other's way.
    All,
    Nothing,
    One(Index),
}

impl Choices {
    pub(super) fn new(root: &Root, path: &Path, options: &LoadOptions) -> Result<Self, LoadError> {
        let choose = |what: &'static str, wanted: &str, names: Vec<&str>| {
            chosen(wanted, &names).map_err(|available| LoadError::NoChoice {
                path: path.to_owned(),
                what,
                wanted: wanted.to_owned(),
                available,
            })
        };
        let scene = match &options.scene {
            Some(wanted) => {
                let names = root.scenes.iter().map(|scene| scene.name.as_deref().unwrap_or_default());
                Some(choose("scene", wanted, names.collect())?)
            }
            None => None,
        };
        let clip = match options.clip.as_deref() {
            None | Some("all") => ClipChoice::All,
            Some("none") => ClipChoice::Nothing,
            Some(wanted) => {
                let names = root.animations.iter().map(|clip| clip.name.as_deref().unwrap_or_default());
                ClipChoice::One(choose("clip", wanted, names.collect())?)
            }
        };
        let variant = match &options.variant {
            Some(wanted) => {
                let names = root.extensions.variants.variants.iter().map(|variant| variant.name.as_str());
                Some(choose("variant", wanted, names.collect())?)
            }
            None => None,
        };
        Ok(Self { scene, clip, variant })
    }

    /// Whether an animation may play.
    pub(super) fn plays(&self, animation: Index) -> bool {
        match self.clip {
            ClipChoice::All => true,
            ClipChoice::Nothing => false,
            ClipChoice::One(chosen) => chosen == animation,
        }
    }

    /// The material of a primitive.
    pub(super) fn material_of(&self, primitive: &Primitive) -> Option<Index> {
        let mappings = &primitive.extensions.variants.mappings;
        let mapped = self
            .variant
            .and_then(|variant| mappings.iter().find(|mapping| mapping.variants.contains(&variant)));
        mapped.map(|mapping| mapping.material).or(primitive.material)
    }
}
