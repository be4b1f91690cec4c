//! Which spheres a ray tests: all of them, or those that a tree of boxes leaves for a given ray; and the closest hit among them.
//! The lists of viewing rays are in `certify/`.

pub(crate) mod eight;
#[cfg(test)]
pub(crate) mod nearest;
pub(crate) mod tree;
