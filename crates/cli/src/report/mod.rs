//! What commands report, one file a format.

pub(crate) mod listing;
