//! Figures and pages of the results. Reads results, computes none.
//!
//! [`page()`] is one self-contained HTML file: static figures and tables, and over them the explorer, a script of our own that
//! reads the same JSON as the reader has (`run.json`, `figures.json`, embedded). No address outside the file, and a content
//! security policy that allows none. Without the script the page still shows every figure. [`Live`] makes it compute, too. [`paper`] writes the figures as files.

pub(crate) mod classes_over_time;
mod confusion;
pub(crate) mod early_exits;
mod explorer;
#[cfg(feature = "train")]
pub(crate) mod fidelity;
pub(crate) mod figures;
pub(crate) mod gallery;
mod live;
mod page;
pub(crate) mod panels;
pub mod paper;
pub(crate) mod plot;
pub(crate) mod recordings;
pub(crate) mod spectrograms;
#[cfg(feature = "train")]
pub(crate) mod studies;
pub mod sweep;
pub(crate) mod tables;
pub(crate) mod timeline;

pub use live::Live;
pub use page::page;

const STYLE: &str = include_str!("style.css");
