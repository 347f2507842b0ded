//! What commands report, one file a format.

mod chart;
pub(crate) mod comparison;
pub(crate) mod html;
pub(crate) mod json;
pub(crate) mod listing;
pub(crate) mod table;
