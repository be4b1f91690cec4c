//! The bounds under attack. f32 as the worst device would compute it (`wild`), scenes that hurt (`worlds`), the claims
//! held against the judge (`claims`, `sound`) and each bound against the very quantity it bounds (`bounds`); then every
//! constant is taken away in turn, and somebody must notice (`sabotage`). Single suspicions are in `corners`, what lists leave
//! out in `cover`, what the host rounds in `host`. Truths have axes of their own (`axes`).

mod axes;
mod bounds;
mod claims;
mod corners;
mod cover;
mod first_order;
mod host;
mod predicted;
mod sabotage;
mod single;
mod sound;
mod tape;
mod wild;
mod window;
mod worlds;
