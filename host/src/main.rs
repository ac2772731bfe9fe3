//! The sdp3 command.
fn main() {}
