//! Raw chirps of a radar module, `[frame, chirp, antenna, sample]`, of which one antenna and one chirp a frame are taken.
//!
//! A cube is never reduced unasked: where it has several antennas or chirps, the user states which.

use super::{Contents, MeasuredError, Samples, Source, Stated};
use crate::formats::slots::Slots;
use crate::results::{About, Sensor};
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

/// Share by which the chirps of a frame may differ from filling it.
const UNIFORM: f64 = 0.01;

/// Which chirps of a frame are slow time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Chirps {
    /// One of each frame, from 1.
    One(u32),
    /// All of them, where they follow one another without a pause between frames.
    All,
}

impl FromStr for Chirps {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "all" => Ok(Self::All),
            _ => text.parse().map(Self::One).map_err(|_| "a number from 1, or all".to_owned()),
        }
    }
}

impl Display for Chirps {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::One(n) => write!(f, "{n}"),
            Self::All => write!(f, "all"),
        }
    }
}

/// Chirps as they were recorded.
#[derive(Debug)]
pub(super) struct Cube {
    /// `[frame, chirp, antenna, sample]`; of complex samples I and Q alternate.
    pub values: Vec<i16>,
    pub sensor: Sensor,
}

impl Cube {
    /// Values of a chirp of one antenna.
    fn per_chirp(&self) -> usize {
        self.sensor.samples as usize * if self.sensor.complex { 2 } else { 1 }
    }

    /// Values of a frame.
    pub(super) fn per_frame(&self) -> usize {
        self.sensor.chirps as usize * self.sensor.antennas as usize * self.per_chirp()
    }

    /// Lengths of frames, chirps, antennas and samples.
    pub(super) fn shape(&self) -> [usize; 4] {
        let Sensor { chirps, antennas, samples, .. } = self.sensor;
        let [chirps, antennas, samples] = [chirps, antennas, samples].map(|n| n as usize);
        [self.values.len() / self.per_frame().max(1), chirps, antennas, samples]
    }

    /// The slots of the antenna and the chirps that were stated.
    pub(super) fn contents(
        self,
        source: Source,
        stated: &Stated,
        format: &str,
    ) -> Result<Contents, MeasuredError> {
        let about = About {
            format: format.to_owned(),
            axes: "[frame, chirp, antenna, sample]".to_owned(),
            shape: self.shape().to_vec(),
            sensor: Some(self.sensor.clone()),
        };
        let Sensor { antennas, chirps, chirp_s, frame_s, .. } = self.sensor;
        let antenna = one_of(source, "--antenna", stated.antenna.or(stated.first.then_some(1)), antennas)?;
        let gap = (frame_s - f64::from(chirps) * chirp_s).abs() > UNIFORM * frame_s;
        let (first, count, interval_s) = match stated.chirp.or(stated.first.then_some(Chirps::One(1))) {
            Some(Chirps::All) if gap && chirps > 1 => {
                let legal = format!(
                    "1 to {chirps}: {chirps} chirps of {} us in a frame of {} us leave a pause",
                    1e6 * chirp_s,
                    1e6 * frame_s
                );
                return Err(source.value("--chirp", "all", legal));
            }
            Some(Chirps::All) => (0, chirps as usize, frame_s / f64::from(chirps)),
            Some(Chirps::One(n)) => (one_of(source, "--chirp", Some(n), chirps)?, 1, frame_s),
            None => (one_of(source, "--chirp", None, chirps)?, 1, frame_s),
        };
        let per_slot = self.per_chirp();
        let mut slots = Slots::with_capacity(per_slot, self.shape()[0] * count);
        for frame in self.values.chunks_exact(self.per_frame()) {
            for chirp in frame.chunks_exact(antennas as usize * per_slot).skip(first).take(count) {
                slots.values.extend_from_slice(&chirp[antenna * per_slot..][..per_slot]);
            }
        }
        Ok(Contents {
            samples: Samples::Slots(slots),
            rate_hz: Some(1.0 / interval_s),
            carrier_hz: Some(self.sensor.carrier_hz),
            about,
        })
    }
}

/// The one stated of `count`, from 0; the only one where none is.
fn one_of(source: Source, flag: &str, stated: Option<u32>, count: u32) -> Result<usize, MeasuredError> {
    match stated {
        None if count == 1 => Ok(0),
        Some(n) if (1..=count).contains(&n) => Ok(n as usize - 1),
        _ => {
            let value = stated.map_or("not given".to_owned(), |n| n.to_string());
            Err(source.value(flag, value, format!("1 to {count}: the recording has {count}")))
        }
    }
}
