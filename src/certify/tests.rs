//! The bounds under attack. f32 as the worst device would compute it (`wild`), scenes that hurt (`worlds`), the claims
//! held against the judge (`claims`, `sound`) and each bound against the very quantity it bounds (`bounds`); then every
//! constant is taken away in turn, and somebody must notice (`sabotage`). Single suspicions are in `corners`, what lists leave
//! out in `cover`.

mod bounds;
mod claims;
mod corners;
mod cover;
mod predicted;
mod sabotage;
mod single;
mod sound;
mod wild;
mod window;
mod worlds;
