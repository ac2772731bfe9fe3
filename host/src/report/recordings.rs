//! Recordings in words and as CSV: what they hold, their windows, what was learned from them.

use super::plot::number;
use crate::formats::table;
use crate::results::{
    Classified, ClassifiedRecording, ClassifiedWindow, Estimate, Inspection, LearnedNetwork,
    LearnedRecordings, SampleFaults, SampleSupervision, UsedExits,
};
use std::fmt::Write;

/// A recording in words: a line a property, then the matching scenario.
pub fn inspection(found: &Inspection) -> String {
    let about = &found.about;
    let shape: Vec<String> = about.shape.iter().map(usize::to_string).collect();
    let mut lines =
        vec![("format", about.format.clone()), ("axes", about.axes.clone()), ("shape", shape.join(" x "))];
    if let Some(s) = &about.sensor {
        let numbers = if s.complex { "complex" } else { "real" };
        let masks: Vec<String> = s.transmitters.iter().map(|mask| format!("{mask:#b}")).collect();
        lines.extend([
            ("sensor", s.name.clone()),
            (
                "sweep",
                format!("{} GHz from {} GHz", number(s.bandwidth_hz / 1e9), number(s.carrier_hz / 1e9)),
            ),
            (
                "samples",
                format!(
                    "{} {numbers} of {} bits at {} MHz",
                    s.samples,
                    s.converter_bits,
                    number(s.sample_rate_hz / 1e6)
                ),
            ),
            (
                "chirps",
                format!(
                    "{} a frame, {} us apart; frames {} ms apart",
                    s.chirps,
                    number(1e6 * s.chirp_s),
                    number(1e3 * s.frame_s)
                ),
            ),
            ("transmit antennas", format!("{}, a mask a chirp", masks.join(" "))),
        ]);
        if let (Some(antenna), Some(chirp)) = (found.antenna, &found.chirp) {
            lines.push((
                "taken",
                format!("antenna {antenna} of {}, chirp {chirp} of {}", s.antennas, s.chirps),
            ));
        }
    }
    lines.extend([
        ("carrier", format!("{} GHz", number(found.carrier_hz / 1e9))),
        ("rate", format!("{} Hz", number(found.rate_hz))),
        ("length", format!("{} s", number(found.seconds))),
        ("mean power", format!("{:.1} dB", found.power_db)),
        ("figures", found.figures.join(", ")),
    ]);
    let mut text: String = lines.iter().map(|(name, value)| format!("{name:18}{value}\n")).collect();
    if let Some(scenario) = &found.scenario {
        let _ = write!(text, "\nscenario that matches the sensor:\n\n{scenario}");
    }
    if let Some(problem) = &found.scenario_problem {
        let _ = write!(text, "\nno scenario: {problem}");
    }
    text.trim_end().to_owned()
}

/// Windows of recordings, one a line.
pub fn classified(found: &Classified) -> String {
    let of = |one: &ClassifiedRecording| {
        let windows = one.windows.iter().map(classified_window);
        let lines: Vec<String> = windows.chain(one.supervision.as_ref().map(supervision)).collect();
        format!("{} ({}), {} slots\n{}", one.file, one.format, one.slots, lines.join("\n"))
    };
    let mut parts: Vec<String> = found.recordings.iter().map(of).collect();
    parts.extend(found.early_exits.as_ref().map(used_exits));
    parts.join("\n")
}

/// The exits that windows were classified with, and the mean number of slots they used.
pub fn used_exits(used: &UsedExits) -> String {
    let slots: Vec<String> = used.sensing_slots.iter().map(u32::to_string).collect();
    let weights = if used.fitted { "fitted weights" } else { "each network's own softmax" };
    format!(
        "mean slots used: {:.1}; exits after {} slots, threshold {}, {weights}",
        used.mean_slots_used,
        slots.join(", "),
        number(used.threshold)
    )
}

/// What the supervision of samples says, a line a fault.
pub fn supervision(said: &SampleSupervision) -> String {
    if said.faults.is_empty() {
        return "supervision of samples: no fault".to_owned();
    }
    let line = |f: &SampleFaults| {
        let SampleFaults { fault, slots, first_slot, first } = f;
        format!("supervision of samples: {fault}: {slots} slots, the first is {first_slot}: {first}")
    };
    said.faults.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// A window: its time, its class, the confidence, the slots it used and how many of them are faulty.
pub fn classified_window(window: &ClassifiedWindow) -> String {
    let ClassifiedWindow { start_s, class, confidence, slots_used, faulty_slots, .. } = window;
    let faulty =
        faulty_slots.filter(|&slots| slots > 0).map_or_else(String::new, |n| format!(", {n} faulty"));
    format!("{start_s:9.3} s  {class:16} {confidence:.3}  {slots_used:4} slots{faulty}")
}

/// Windows as CSV.
pub fn classified_csv(found: &Classified) -> String {
    let windows = found.recordings.iter().flat_map(|r| r.windows.iter().map(|w| (r.file.as_str(), w)));
    let rows: Vec<String> = windows.map(|window| window_csv(Some(window))).collect();
    window_csv(None) + &rows.join("\n")
}

/// A window with its recording's name as a line of CSV without its end; `None`: the header with its end.
pub fn window_csv(window: Option<(&str, &ClassifiedWindow)>) -> String {
    let header =
        ["file", "first_slot", "start_s", "slots_used", "faulty_slots", "class", "confidence", "logits"];
    let Some((file, w)) = window else { return table::csv(&header, []) };
    let logits: Vec<String> = w.logits.iter().map(i8::to_string).collect();
    let cells = [
        file,
        &w.first_slot.to_string(),
        &w.start_s.to_string(),
        &w.slots_used.to_string(),
        &w.faulty_slots.map_or_else(String::new, |slots| slots.to_string()),
        &w.class,
        &w.confidence.to_string(),
        &logits.join(" "),
    ];
    table::csv(&cells, []).trim_end().to_owned()
}

/// How well networks recognise recordings that they did not learn from.
pub fn learned(found: &LearnedRecordings) -> String {
    let mut lines = vec![format!(
        "{} recordings of {} classes, method {}\n  N_s  windows  float   int8  balanced [95 %]          majority",
        found.recordings.len(),
        found.classes.len(),
        found.method
    )];
    lines.extend(found.networks.iter().map(|n| {
        let LearnedNetwork { sensing_slots, windows, float, int8, majority, .. } = n;
        let unknown = n.unknown.as_ref().map_or_else(String::new, |u| {
            format!(
                "    unknown below {:.3}: keeps {:.3}, refuses {:.3}, AUROC {:.3}",
                u.least_confidence, u.known_kept, u.unknown_refused, u.auroc
            )
        });
        let Estimate { mean, low, high } = n.balanced;
        format!("{sensing_slots:5} {windows:8}  {float:.3}  {int8:.3}  {mean:.3} [{low:.3}, {high:.3}]    {majority:.3}{unknown}")
    }));
    lines.join("\n")
}
