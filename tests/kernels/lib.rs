//! The host's vector kernels without the rest of the host. `tests/mutants` changes these files and `tests/miri` runs them under a
//! sanitizer; both need them built in seconds.

/// The folder of the host's sources.
#[path = "../../host/src/network"]
pub mod network {
    pub mod inference;
}
