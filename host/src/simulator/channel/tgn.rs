//! The tables of the TGn channel models A to F, which TGac and TGax keep for indoor rooms up to 40 MHz.
//!
//! 11-03/940r4 Appendix C with 11-09/0308 and 11-14/0882: overlapping clusters on taps, with mean angles and angular spreads.

use crate::scenario::Tgn;
use std::f64::consts::PI;

/// A cluster: powers in dB from its first tap on; mean and spread of its angles of arrival and of departure in degrees.
#[derive(Debug)]
pub struct Cluster {
    pub first: usize,
    pub db: &'static [f64],
    pub arrival: [f64; 2],
    pub departure: [f64; 2],
}

/// A model: tap delays in ns, the rms delay spread in s it is named for, clusters, break point in m, K factor of the first tap.
#[derive(Debug)]
pub struct Table {
    pub delays_ns: &'static [f64],
    pub spread_s: f64,
    pub clusters: &'static [Cluster],
    pub break_m: f64,
    pub k: f64,
}

const fn cluster(first: usize, db: &'static [f64], arrival: [f64; 2], departure: [f64; 2]) -> Cluster {
    Cluster { first, db, arrival, departure }
}

const A: Table = Table {
    delays_ns: &[0.],
    spread_s: 0.0,
    clusters: &[cluster(0, &[0.0], [45.0, 40.0], [45.0, 40.0])],
    break_m: 5.0,
    k: 1.0,
};

const B: Table = Table {
    delays_ns: &[0., 10., 20., 30., 40., 50., 60., 70., 80.],
    spread_s: 15e-9,
    clusters: &[
        cluster(0, &[0.0, -5.4, -10.8, -16.2, -21.7], [4.39, 14.47], [225.11, 14.45]),
        cluster(2, &[-3.2, -6.3, -9.4, -12.5, -15.6, -18.7, -21.8], [118.43, 25.26], [106.55, 25.43]),
    ],
    break_m: 5.0,
    k: 1.0,
};

const C: Table = Table {
    delays_ns: &[0., 10., 20., 30., 40., 50., 60., 70., 80., 90., 110., 140., 170., 200.],
    spread_s: 30e-9,
    clusters: &[
        cluster(
            0,
            &[0.0, -2.1, -4.3, -6.5, -8.6, -10.8, -13.0, -15.2, -17.3, -19.5],
            [290.37, 24.69],
            [13.53, 24.79],
        ),
        cluster(6, &[-5.0, -7.2, -9.3, -11.5, -13.7, -15.8, -18.0, -20.2], [332.38, 22.45], [56.43, 22.57]),
    ],
    break_m: 5.0,
    k: 1.0,
};

const D: Table = Table {
    delays_ns: &[
        0., 10., 20., 30., 40., 50., 60., 70., 80., 90., 110., 140., 170., 200., 240., 290., 340., 390.,
    ],
    spread_s: 50e-9,
    clusters: &[
        cluster(
            0,
            &[
                0.0, -0.9, -1.7, -2.6, -3.5, -4.3, -5.2, -6.1, -6.9, -7.8, -9.0, -11.1, -13.7, -16.3, -19.3,
                -23.2,
            ],
            [158.93, 27.76],
            [332.10, 27.44],
        ),
        cluster(10, &[-6.6, -9.5, -12.1, -14.7, -17.4, -21.9, -25.5], [320.29, 31.47], [49.38, 32.14]),
        cluster(14, &[-18.8, -23.2, -25.2, -26.7], [276.12, 37.42], [275.98, 36.88]),
    ],
    break_m: 10.0,
    k: 1.995_262_314_968_88, // 3 dB
};

const E: Table = Table {
    delays_ns: &[
        0., 10., 20., 30., 50., 80., 110., 140., 180., 230., 280., 330., 380., 430., 490., 560., 640., 730.,
    ],
    spread_s: 100e-9,
    clusters: &[
        cluster(
            0,
            &[-2.6, -3.0, -3.5, -3.9, -4.5, -5.6, -6.9, -8.2, -9.8, -11.7, -13.9, -16.1, -18.3, -20.5, -22.9],
            [163.7, 35.8],
            [105.6, 36.1],
        ),
        cluster(
            4,
            &[-1.8, -3.2, -4.5, -5.8, -7.1, -9.9, -10.3, -14.3, -14.7, -18.7, -19.9, -22.4],
            [251.8, 41.6],
            [293.1, 42.5],
        ),
        cluster(8, &[-7.9, -9.6, -14.2, -13.8, -18.6, -18.1, -22.8], [80.0, 37.4], [61.9, 38.0]),
        cluster(14, &[-20.6, -20.5, -20.7, -24.6], [182.0, 40.3], [275.7, 38.7]),
    ],
    break_m: 20.0,
    k: 3.981_071_705_534_97, // 6 dB
};

const F: Table = Table {
    delays_ns: &[
        0., 10., 20., 30., 50., 80., 110., 140., 180., 230., 280., 330., 400., 490., 600., 730., 880., 1050.,
    ],
    spread_s: 150e-9,
    clusters: &[
        cluster(
            0,
            &[-3.3, -3.6, -3.9, -4.2, -4.6, -5.3, -6.2, -7.1, -8.2, -9.5, -11.0, -12.5, -14.3, -16.7, -19.9],
            [315.1, 48.0],
            [56.2, 41.6],
        ),
        cluster(
            4,
            &[-1.8, -2.8, -3.5, -4.4, -5.3, -7.4, -7.0, -10.3, -10.4, -13.8, -15.7, -19.9],
            [180.4, 55.0],
            [183.7, 55.2],
        ),
        cluster(8, &[-5.7, -6.7, -10.4, -9.6, -14.1, -12.7, -18.5], [74.7, 42.0], [153.0, 47.4]),
        cluster(12, &[-8.8, -13.3, -18.7], [251.5, 28.6], [112.5, 27.2]),
        cluster(14, &[-12.9, -14.2], [68.5, 30.7], [291.0, 33.0]),
        cluster(16, &[-16.3, -21.2], [246.2, 38.2], [62.3, 38.0]),
    ],
    break_m: 30.0,
    k: 3.981_071_705_534_97, // 6 dB
};

pub fn table(model: Tgn) -> &'static Table {
    match model {
        Tgn::A => &A,
        Tgn::B => &B,
        Tgn::C => &C,
        Tgn::D => &D,
        Tgn::E => &E,
        Tgn::F => &F,
    }
}

/// Delay in s, mean power (they sum to 1) and mean azimuth of arrival in rad of each tap.
///
/// The printed tables of B to F have rms delay spreads of 15.65, 33.44, 50.16, 98.98 and 148.80 ns; delays, which nothing here ties to a
/// grid, are scaled so that the spreads are the nominal ones.
pub fn tap_powers(model: Tgn) -> Vec<(f64, f64, f64)> {
    let table = table(model);
    let mut taps: Vec<(f64, f64, f64, f64)> =
        table.delays_ns.iter().map(|ns| (ns * 1e-9, 0.0, 0.0, 0.0)).collect();
    for cluster in table.clusters {
        for (tap, db) in taps[cluster.first..].iter_mut().zip(cluster.db) {
            let power = libm::pow(10.0, db / 10.0);
            tap.1 += power;
            if power > tap.3 {
                (tap.2, tap.3) = (cluster.arrival[0] * PI / 180.0, power);
            }
        }
    }
    let moment = |n: i32| -> f64 { taps.iter().map(|tap| tap.1 * tap.0.powi(n)).sum() };
    let (total, mean) = (moment(0), moment(1) / moment(0));
    let spread = (moment(2) / total - mean * mean).max(0.0).sqrt();
    let scale = if spread > 0.0 { table.spread_s / spread } else { 1.0 };
    taps.into_iter().map(|(delay, power, azimuth, _)| (delay * scale, power / total, azimuth)).collect()
}
