//! Which way a 3x3 convolution is computed: by Winograd's transforms where products cost most, else directly.

use super::layer::Convolution;
use super::packing::transforms;
use crate::simd::{Job, Lanes};

impl Job for Convolution<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        if L::INPUTS == 2 && transforms(self.layer.inputs) {
            let _ = match self.layer.inputs {
                16 => self.winograd::<L, 8>(lanes),
                _ => self.winograd::<L, 16>(lanes),
            };
            return;
        }
        match self.layer.inputs / 4 {
            1 => self.direct::<L, 1>(lanes),
            2 => self.direct::<L, 2>(lanes),
            3 => self.direct::<L, 3>(lanes),
            4 => self.direct::<L, 4>(lanes),
            5 => self.direct::<L, 5>(lanes),
            6 => self.direct::<L, 6>(lanes),
            7 => self.direct::<L, 7>(lanes),
            _ => self.direct::<L, 8>(lanes),
        }
    }
}
