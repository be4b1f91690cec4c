//! Answers of the server to requests that an attacker may send, and to the page itself.

#[path = "attacks/client.rs"]
mod client;
#[path = "attacks/connections.rs"]
mod connections;
#[path = "attacks/frames.rs"]
mod frames;
#[path = "attacks/stage.rs"]
mod stage;
#[path = "attacks/table.rs"]
mod table;
