//! What this binary is.

/// The commit that it was built from, or `unknown`.
pub(crate) const COMMIT: &str = env!("SHEER_COMMIT");
/// The version of the package.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");
