//! The device side: which adapter, which shader text, and the dispatches of a frame.

pub(crate) mod alone;
mod busy;
mod clock;
pub(crate) mod compose;
pub(crate) mod device;
pub(crate) mod dispatch;
pub(crate) mod input;
pub(crate) mod layout;
pub(crate) mod resident;
pub(crate) mod room;
pub(crate) mod selftest;
mod sizes;
pub(crate) mod submission_budget;
mod submit;
#[cfg(test)]
mod tests;
pub(crate) mod texture;
pub(crate) mod traffic;
pub(crate) mod transfers;
mod validate;
mod wait;
pub(crate) mod work;

pub(crate) use dispatch::Gpu;
