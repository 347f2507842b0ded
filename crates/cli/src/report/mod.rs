//! What commands report, one file a format.

pub(crate) mod benchmark;
pub(crate) mod calibration;
pub(crate) mod chart;
pub(crate) mod data_files;
pub(crate) mod experiments;
pub(crate) mod inspection;
pub(crate) mod json;
pub(crate) mod listing;
pub(crate) mod page;
pub(crate) mod table;
