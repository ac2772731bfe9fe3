//! Spectrograms of standing, pacing and walking adults: with one person at 3.5 GHz, with two at 60 GHz.

use super::made::Made;
use super::settings::Settings;
use super::work::Work;
use crate::error::Failure;
use crate::network::spectrograms::example;
use crate::report::plot::Medium;
use crate::report::spectrograms;
use crate::scenario::Class;

/// A panel of a figure with three columns.
const PANEL: Medium = Medium { width: 352.0, height: 250.0, font: 11.0, left: 0.0, bottom: 0.0, mm: 0.0 };

pub fn make(work: &Work<'_>) -> Result<Made, Failure> {
    let mut made = Made {
        caption: "Spectrograms of standing, pacing and walking (Fig. 3)",
        columns: 3,
        ..Made::default()
    };
    for settings in Settings::BOTH {
        for (carrier_hz, interferer) in [(3.5e9, false), (60e9, true)] {
            let mut scenario = work.scenario(settings, carrier_hz);
            scenario.channel.interferer = interferer;
            for class in [Class::Standing, Class::AdultPacing, Class::AdultWalking] {
                let title = format!("{}, {} GHz", class.name(), carrier_hz / 1e9);
                let picture = example(&scenario, &title, class, work.seeds[0]);
                let scene = if interferer { 2 } else { 1 };
                let caption = format!(
                    "{}, {} GHz, scenario {scene}, {}",
                    class.name(),
                    carrier_hz / 1e9,
                    settings.words()
                );
                made.panels.push((caption, spectrograms::svg(&picture, PANEL)));
            }
        }
    }
    made.notes.push(
        "The paper's recordings are not public, and it states no number of these pictures: they can be looked at, not compared.".into(),
    );
    Ok(made)
}
