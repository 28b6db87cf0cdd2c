//! Bounding volume hierarchies over boxes.
