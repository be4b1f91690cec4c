//! Adversarial tests of the bounds. `wild` is f32 with the worst rounding that WGSL allows, `worlds` generates hard
//! scenes, `claims` and `sound` compare certified claims with exact arithmetic, `bounds` and `first_order` compare each
//! bound with the quantity that it bounds, in the `shots` of single spheres, and `sabotage` removes each constant in turn,
//! which a test must detect. `corners` has single critical cases, `cover`, `near` and `enclose` test which spheres may be
//! omitted, `host` the rounding of the host. `given` and `given_device` do the same for given rays, in f64 and in
//! f32, `starts` for rays that a device starts from hits. `axes` computes a camera's axes independently.

mod axes;
mod bounds;
mod claims;
mod corners;
mod cover;
mod enclose;
mod first_order;
mod general_lists;
mod given;
mod given_device;
mod host;
mod mirrors;
mod planes;
mod predicted;
mod sabotage;
mod shots;
mod single;
mod sound;
mod starts;
mod tape;
mod wild;
mod window;
mod worlds;
