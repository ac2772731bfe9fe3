//! What stands between the radar module and a world that fails.
//!
//! | fault | found by | answer |
//! |---|---|---|
//! | slots skipped, repeated, late; a counter that wraps or jumps | [`watch`]: the radio numbers its slots | played through as lost, given again, refused; else a new period |
//! | a bit of the schedule's memory flips | [`watch`]: a seal over all its words | a new period from a sealed spare |
//! | a reset in any slot | [`watch`]: the state kept in memory that survives | goes on; without it a new period |
//! | a converter that saturates, sticks, is silent or off its zero | [`health`] | the slot counts as lost |
//! | a bit of a model flips | [`intact`]: the checksum taken when it was accepted | it is not run |
//!
//! Every fault is told once; the next whole period is as if it had not been. [`station::Guarded`] is the slot loop with all of it.
//!
//! ```
//! use sdp3_core::early_exit::{Anytime, Exit};
//! use sdp3_core::dims::Slot;
//! use sdp3_core::supervision::{Guarded, Intact, Watch, watch::WORDS};
//! use sdp3_core::pipeline::StandardMemory;
//! use sdp3_core::scheduler::{Sensing, SlotUse};
//!
//! # struct Radio;
//! # impl Radio {
//! #     fn next_number(&self) -> u32 { 0 }
//! #     fn number(&mut self) -> Option<u32> { None }
//! #     fn samples(&mut self) -> Option<&'static Slot> { None }
//! # }
//! # fn tell<T>(_: T) {}
//! // `kept` survives a reset: RAM that start-up leaves alone
//! fn station(
//!     model: &'static [u8],
//!     memory: &mut StandardMemory,
//!     kept: &mut [u32; WORDS],
//!     radio: &mut Radio,
//! ) -> Result<(), &'static str> {
//!     let (intact, model) = Intact::accept(model).map_err(|_| "no model")?;
//!     let sensing = Sensing::new(4000, 3, 1000).map_err(|_| "N_s (N_m + 1) > N")?;
//!     let watch = Watch::new(sensing, [4, 3, 3, 0, 0, 0, 0, 0], radio.next_number());
//!     let mut buffers = memory.view();
//!     let kernels = buffers.take_kernels(&model).map_err(|_| "too little memory")?;
//!     let receiver: Anytime<_> =
//!         Anytime::new([Exit::alone(model, kernels)], 2.0, buffers).map_err(|_| "too little memory")?;
//!     let mut station = Guarded::new(watch, receiver, [intact].into_iter().collect());
//!     if !station.restore(kept) {
//!         tell("nothing whole was kept: a period begins with the radio's next slot");
//!     }
//!     while let Some(number) = radio.number() {
//!         let begun = station.begin(number);
//!         begun.troubles.iter().for_each(tell);
//!         if let (SlotUse::Sensing, Some(samples)) = (begun.slot, radio.samples()) {
//!             match station.sensed(number, samples) {
//!                 Ok(Some(verdict)) => tell(verdict.class),
//!                 Ok(None) => (),
//!                 Err(trouble) => tell(trouble),
//!             }
//!         }
//!         station.watch().save(kept);
//!     }
//!     Ok(())
//! }
//! let mut memory = Box::new(StandardMemory::new());
//! assert_eq!(station(b"not a model", &mut memory, &mut [0; WORDS], &mut Radio), Err("no model"));
//! ```

pub mod sample_health;
pub mod station;
pub mod verified_image;
pub mod watch;

pub use sample_health::SampleFault;
pub use station::Guarded;
pub use verified_image::Intact;
pub use watch::{Fault, Step, Watch};
