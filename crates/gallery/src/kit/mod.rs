//! What scenes are furnished with: materials, buildings, plants, figures and machine parts.

pub(crate) mod body;
pub(crate) mod foliage;
pub(crate) mod furniture;
pub(crate) mod girl;
pub(crate) mod grass;
pub(crate) mod hair;
pub(crate) mod house;
pub(crate) mod leaf;
pub(crate) mod mechanical;
pub(crate) mod palette;
pub(crate) mod smoke;
pub(crate) mod square;
pub(crate) mod wind;
