//! What a recording holds: shape, sensor and rate, pictures over time, and the scenario that matches the sensor.

use super::Job;
use crate::error::Failure;
use crate::recordings::{self, Chirps, Samples, Signal, Stated};
use crate::report::{classes_over_time::OverTime, paper, plot::Medium, spectrograms};
use crate::results::{Inspection, Sensor, Spectrogram};
use crate::scenario::{SPEED_OF_LIGHT, Scenario};
use crate::simulator::calibration::doppler::{COLUMNS, WINDOW, of_cells, of_signal};
use crate::simulator::calibration::intensity::RANGE_DB;
use crate::simulator::channel::Complex64;
use crate::store::digest::sha256;
use rustfft::FftPlannerScalar;
use std::f64::consts::PI;
use std::path::Path;

/// Ranges that a matching scenario's gate covers, in m, and its range samples.
const GATE_M: [f64; 2] = [0.9, 5.7];
const GATE_SAMPLES: u32 = 8;
/// Seconds of sensing slots that a matching scenario studies, and of its period.
const SENSING_S: [f64; 6] = [0.2, 0.3, 0.4, 0.5, 0.6, 0.8];
const PERIOD_S: f64 = 2.0;
/// Most slots a second of a Doppler sensor's scenario: limbs at 60 GHz take no more.
const FASTEST_SLOTS_HZ: f64 = 4000.0;

impl Job {
    /// Reads a recording and draws it: `doppler-time.*`, and of a radar module's chirps `range-time.*`.
    ///
    /// # Errors
    ///
    /// An unreadable recording; raw slots of another radar than the scenario's; a folder that cannot be written.
    pub fn inspect(&self, file: &Path, stated: &Stated) -> Result<Inspection, Failure> {
        let signal = recordings::open(file, &Stated { first: true, ..stated.clone() })?;
        let title = file.file_name().unwrap_or_default().to_string_lossy();
        let mut pictures = Vec::new();
        let mut scenario_problem = None;
        let carrier_hz = signal.carrier_hz;
        match (&signal.samples, &signal.about.sensor) {
            (Samples::Slots(_), Some(sensor)) => {
                let profiles = range_profiles(&signal, sensor);
                let cells = profiles.first().map_or(0, Vec::len);
                let slow = (0..cells).map(|cell| profiles.iter().map(|profile| profile[cell]).collect());
                let doppler = of_cells(&title, slow.collect(), signal.rate_hz, false, carrier_hz);
                pictures.push(("doppler-time", spectrograms::svg(&doppler, Medium::SINGLE)));
                let high_m = profiles.first().map_or(0, Vec::len) as f64 * SPEED_OF_LIGHT
                    / (2.0 * sensor.bandwidth_hz);
                let range = range_time(&title, &signal, &profiles);
                pictures.push(("range-time", spectrograms::range_time(&range, 0.0, high_m, Medium::SINGLE)));
            }
            _ => match of_signal(&title, &signal, &self.scenario.radar) {
                Ok(doppler) => {
                    pictures.push(("doppler-time", spectrograms::svg(&doppler, Medium::SINGLE)));
                }
                // raw slots say nothing of their radar
                Err(other) => scenario_problem = Some(format!("{other}; --scenario names another")),
            },
        }
        for (name, svg) in &pictures {
            paper::draw(&self.output, name, svg)?;
        }
        let mut scenario = None;
        match signal.about.sensor.as_ref().map(|sensor| matching(sensor, signal.rate_hz)) {
            Some(Ok(text)) => scenario = Some(text),
            Some(Err(problem)) => scenario_problem = Some(problem),
            None => (),
        }
        let module = signal.about.sensor.is_some();
        let digested = signal.samples.to_le_bytes();
        let found = Inspection {
            file: file.display().to_string(),
            about: signal.about,
            rate_hz: signal.rate_hz,
            carrier_hz: signal.carrier_hz,
            seconds: signal.samples.len() as f64 / signal.rate_hz,
            power_db: signal.power_db,
            samples_sha256: sha256([&digested[..]]),
            antenna: module.then(|| stated.antenna.unwrap_or(1)),
            chirp: module.then(|| stated.chirp.unwrap_or(Chirps::One(1)).to_string()),
            scenario,
            scenario_problem,
            figures: pictures.into_iter().map(|(name, _)| name.to_owned()).collect(),
        };
        self.output.write_result("inspection.json", &found)?;
        Ok(found)
    }
}

/// The spectrogram of slow time on its time axis: a column is centred on its window.
pub(super) fn doppler_over_time(
    title: &str,
    slow: Vec<Complex64>,
    real: bool,
    rate_hz: f64,
    carrier_hz: f64,
) -> OverTime {
    let window_s = WINDOW.min(slow.len()) as f64 / rate_hz;
    let spectrogram = of_cells(title, vec![slow], rate_hz, real, carrier_hz);
    let first_s = ((window_s - spectrogram.frame_s) / 2.0).max(0.0);
    OverTime { spectrogram, first_s, slot_rate_hz: rate_hz }
}

/// For every slot the beat spectrum over range, `[slot][cell]`, Hann window; of real samples the positive half.
fn range_profiles(signal: &Signal, sensor: &Sensor) -> Vec<Vec<Complex64>> {
    let Samples::Slots(slots) = &signal.samples else { return Vec::new() };
    let samples = sensor.samples as usize;
    let fft = FftPlannerScalar::new().plan_fft_forward(samples);
    let window: Vec<f64> =
        (0..samples).map(|n| (PI * (n as f64 + 0.5) / samples as f64).sin().powi(2)).collect();
    let cells = if sensor.complex { samples } else { samples / 2 };
    let profile = |slot: &[i16]| {
        let value = |n: usize| match sensor.complex {
            true => Complex64::new(f64::from(slot[2 * n]), f64::from(slot[2 * n + 1])),
            false => Complex64::new(f64::from(slot[n]), 0.0),
        };
        let mut beat: Vec<Complex64> = (0..samples).map(|n| value(n) * window[n]).collect();
        fft.process(&mut beat);
        beat.truncate(cells);
        beat
    };
    slots.iter().map(profile).collect()
}

/// Power over range and time, without what stands still; a column is the mean power of the slots in it.
fn range_time(title: &str, signal: &Signal, profiles: &[Vec<Complex64>]) -> Spectrogram {
    let cells = profiles.first().map_or(0, Vec::len);
    let mean: Vec<Complex64> = (0..cells)
        .map(|cell| profiles.iter().map(|p| p[cell]).sum::<Complex64>() / profiles.len() as f64)
        .collect();
    let each = profiles.len().div_ceil(COLUMNS).max(1);
    let column = |slots: &[Vec<Complex64>]| -> Vec<f64> {
        let power = |cell: usize| slots.iter().map(|p| (p[cell] - mean[cell]).norm_sqr()).sum::<f64>();
        (0..cells).map(|cell| 10.0 * libm::log10((power(cell) / slots.len() as f64).max(1e-300))).collect()
    };
    let columns: Vec<Vec<f64>> = profiles.chunks(each).map(column).collect();
    let most = columns.iter().flatten().copied().fold(f64::MIN, f64::max);
    let pixel = |cell: usize| {
        columns.iter().map(move |c| ((1.0 + (c[cell] - most) / RANGE_DB).clamp(0.0, 1.0) * 255.0) as u8)
    };
    Spectrogram {
        title: title.to_owned(),
        rows: cells as u32,
        frames: columns.len() as u32,
        first_row_hz: 0.0,
        row_hz: 0.0,
        frame_s: each as f64 / signal.rate_hz,
        carrier_hz: signal.carrier_hz,
        range_db: RANGE_DB,
        intensities: (0..cells).flat_map(pixel).collect(),
    }
}

/// The scenario in TOML that has this sensor as its radar, with slots at this rate; else why there is none.
fn matching(sensor: &Sensor, rate_hz: f64) -> Result<String, String> {
    let format = if sensor.complex { "complex" } else { "real" };
    let (radar, slot_rate_hz, spectrogram) = if sensor.bandwidth_hz == 0.0 {
        // a slot is a sample, as in `doppler-24ghz`; of one output the rows are half of the frequencies
        let rows = if sensor.complex { 4 } else { 2 };
        (
            "bandwidth_hz = 1e6\nsweep_s = 1e-5\nsample_rate_hz = 1e5\nsamples = 1\nrange_samples = 1\nac_coupling_hz = 20.0\n".to_owned(),
            rate_hz / (rate_hz / FASTEST_SLOTS_HZ).ceil().max(1.0),
            format!("bins_per_row = {rows}\nfirst_kept = 1\n"),
        )
    } else {
        let cell_m = SPEED_OF_LIGHT / (2.0 * sensor.bandwidth_hz);
        let bins = |metres: f64| (metres / cell_m).round();
        let [near, far] = GATE_M;
        let radar = format!(
            "bandwidth_hz = {:e}\nsweep_s = {:e}\nsample_rate_hz = {:e}\nsamples = {}\nconverter_bits = {}\n\
             range_samples = {GATE_SAMPLES}\nfirst_bin = {}\nbins_per_sample = {}\n",
            sensor.bandwidth_hz,
            f64::from(sensor.samples) / sensor.sample_rate_hz,
            sensor.sample_rate_hz,
            sensor.samples,
            sensor.converter_bits,
            bins(near).max(1.0),
            bins((far - near) / f64::from(GATE_SAMPLES)).max(1.0),
        );
        (radar, rate_hz, "bins_per_row = 4\n".to_owned())
    };
    let slots = |seconds: f64| (seconds * slot_rate_hz).round();
    let sensing: Vec<String> = SENSING_S.iter().map(|&s| slots(s).to_string()).collect();
    let text = format!(
        "name = \"sensor\"\n\n[radar]\ncarrier_hz = {:e}\nformat = \"{format}\"\ndechirp = \"analog\"\n{radar}\n[frame]\n\
         slot_s = {:e}\nperiod_slots = {}\nspacing_slots = 0\nsensing_slots = [{}]\n\n[spectrogram]\n{spectrogram}",
        sensor.carrier_hz,
        1.0 / slot_rate_hz,
        slots(PERIOD_S),
        sensing.join(", "),
    );
    match Scenario::parse(&text, Path::new("sensor")) {
        Ok(_) => Ok(text),
        Err(error) => Err(error.to_string()),
    }
}
