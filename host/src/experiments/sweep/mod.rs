//! A sweep: a plan of scenarios x carriers x rho x N_s x seeds, every cell an experiment of its own, on one machine or many.
//!
//! Not `optimize --sweep` ([`crate::optimizer::sweep`]), which varies the communication of one scenario and trains nothing: here
//! every cell simulates, trains, quantises, tests through the core, and computes what the remaining slots carry.
//!
//! [`plan`] reads and resolves, [`shard`] assigns cells to shards, `cell` measures (in builds that train), [`store`] keeps a
//! cell in a file that says what it belongs to, [`status`] counts them, [`merge`] puts them together. [`slurm`] and [`kubernetes`] write the jobs.
//!
//! A folder holds `sweep.toml` (the resolved plan; it needs no other file), `cells/00000.json` ..., and, merged, `merged.csv` and
//! `merged.json`, or of a partial merge `partial.csv` and `partial.json`. Every byte depends on the plan and the program's version alone.

#[cfg(feature = "train")]
mod cell;
pub mod kubernetes;
pub(crate) mod merge;
pub mod plan;
#[cfg(feature = "train")]
pub(crate) mod run;
pub(crate) mod shard;
pub mod slurm;
pub(crate) mod status;
pub mod store;

#[cfg(test)]
mod tests;
