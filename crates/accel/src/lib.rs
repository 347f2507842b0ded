//! CPU bounding volume hierarchy: closest, any and all hits.
