//! Which spheres a ray tests, without a certificate: lists per tile for viewing rays, a tree of boxes for given rays; and
//! the closest hit among them. The certified lists are in `certify/`.

pub(crate) mod eight;
pub(crate) mod nearest;
pub(crate) mod tile_candidates;
pub(crate) mod tree;
