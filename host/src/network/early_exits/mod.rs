//! Early exits, trained: the weight of each exit's logits, and the effect of a threshold.
//!
//! Of the logits of every exit's network ([`super::evaluation`]) [`calibration`] fits the weights of evidence, [`policy`] plays
//! thresholds, [`gallery`] says where the gallery's recordings stop. Evidence and decision are the core's own arithmetic
//! ([`sdp3_core::early_exit`]).

pub(crate) mod calibration;
pub(crate) mod gallery;
pub(crate) mod policy;
pub mod stored;

pub use policy::Policy;

use sdp3_core::dsn::Model;
use sdp3_core::early_exit::{EXITS, EarlyExit};

/// A network with the weights that were fitted to its exit.
pub fn fitted<'m>(model: Model<'m>, weights: &[i32]) -> EarlyExit<'m> {
    let mut all = [0; EXITS];
    all.iter_mut().zip(weights).for_each(|(to, from)| *to = *from);
    EarlyExit { model, weights: all }
}

/// A network as exit number `exit`, from 0, without fitted weights: its confidence is its own softmax.
pub fn unfitted(model: Model<'_>, exit: usize) -> EarlyExit<'_> {
    let [own, ..] = EarlyExit::single(model).weights;
    let weights = std::array::from_fn(|k| if k == exit { own } else { 0 });
    EarlyExit { model, weights }
}
