//! Presets: sizes of a first result and of comparisons, where neither the scenario's file nor the command line states one.

use super::read::text_of;
use super::{Override, Scenario, ScenarioError};
use std::path::Path;
use toml::Table;

/// Section, field and value.
type Sizes = [(&'static str, &'static str, &'static str)];

/// For a first result.
const QUICK: [(&str, &str, &str); 5] = [
    ("learning", "train_per_class", "100"),
    ("learning", "test_per_class", "60"),
    ("learning", "windows", "4"),
    ("learning", "epochs", "12"),
    ("learning", "channels", "8"),
];

/// For comparisons of many trainings: the quick network at one N_s, with more test recordings.
const COMPARISON: [(&str, &str, &str); 6] = {
    let [train, _, windows, epochs, channels] = QUICK;
    let test = ("learning", "test_per_class", "100");
    [train, test, windows, epochs, channels, ("frame", "sensing_slots", "[300]")]
};

impl Scenario {
    /// As [`Scenario::resolve`], with quick sizes where neither the file nor `set` states one; and what the preset set, in words.
    ///
    /// # Errors
    ///
    /// The first thing that is wrong.
    pub fn quick(file: Option<&Path>, set: &[Override]) -> Result<(Self, String), ScenarioError> {
        Self::preset(file, set, &QUICK, "--preset quick")
    }

    /// As [`Scenario::quick`], of TOML that is in memory; errors name `file` as its origin.
    ///
    /// # Errors
    ///
    /// The first thing that is wrong.
    pub fn quick_text(text: &str, file: &Path, set: &[Override]) -> Result<(Self, String), ScenarioError> {
        Self::parse_with(text, file, set)?.sized(text, set, &QUICK, "--preset quick")
    }

    /// As [`Scenario::quick`], with the sizes of comparisons.
    ///
    /// # Errors
    ///
    /// The first thing that is wrong.
    pub fn comparison(file: Option<&Path>, set: &[Override]) -> Result<(Self, String), ScenarioError> {
        Self::preset(file, set, &COMPARISON, "sizes of comparisons")
    }

    fn preset(
        file: Option<&Path>,
        set: &[Override],
        sizes: &Sizes,
        origin: &str,
    ) -> Result<(Self, String), ScenarioError> {
        let text = file.map(text_of).transpose()?.unwrap_or_default();
        Self::resolve(file, set)?.sized(&text, set, sizes, origin)
    }

    /// This scenario of a TOML, with sizes that neither it nor `set` states.
    fn sized(
        self,
        text: &str,
        set: &[Override],
        sizes: &Sizes,
        origin: &str,
    ) -> Result<(Self, String), ScenarioError> {
        let mut scenario = self;
        let stated = text.parse::<Table>().unwrap_or_default();
        let mut words = Vec::new();
        for (section, key, value) in sizes {
            let field = format!("{section}.{key}");
            let table = stated.get(*section).and_then(|section| section.as_table());
            if table.is_some_and(|table| table.contains_key(*key)) || set.iter().any(|one| one.sets(&field)) {
                continue;
            }
            scenario = Override::new(&field, value).apply(&scenario)?;
            words.push(format!("{key} = {value}"));
        }
        scenario.check(origin)?;
        Ok((scenario, words.join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quick_sizes_give_way_to_what_is_stated() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("room.toml");
        std::fs::write(&file, "[room]\nsize_m = [4.0, 5.0, 3.0]\n[learning]\nepochs = 3\nchannels = 16\n")
            .unwrap();
        let set = ["learning.windows=2".parse().unwrap()];
        let (found, words) = Scenario::quick(Some(&file), &set).unwrap();
        let l = &found.learning;
        assert_eq!((l.train_per_class, l.test_per_class), (100, 60));
        assert_eq!((l.epochs, l.channels, l.windows), (3, 16, 2));
        assert_eq!(found.room.size_m, [4.0, 5.0, 3.0]);
        assert_eq!(words, "train_per_class = 100, test_per_class = 60");
        let text = std::fs::read_to_string(&file).unwrap();
        assert_eq!(Scenario::quick_text(&text, Path::new("text"), &set).unwrap(), (found, words));
        // a built-in scenario's own sizes stay too
        let (found, _) = Scenario::quick(Some(Path::new("small-radar")), &[]).unwrap();
        assert_eq!((found.learning.blocks, found.learning.epochs), (3, 12));
        assert_eq!(found.frame.sensing_slots, [160, 200, 240]);
        assert_eq!(Scenario::quick(None, &[]).unwrap().0.learning.epochs, 12);
        let (found, words) = Scenario::comparison(None, &set).unwrap();
        assert_eq!((found.learning.windows, found.learning.test_per_class), (2, 100));
        assert_eq!(found.frame.sensing_slots, [300]);
        assert!(words.ends_with("channels = 8, sensing_slots = [300]"), "{words}");
    }

    #[test]
    fn a_wrong_file_is_refused_as_without_the_preset() {
        let error = Scenario::quick(Some(Path::new("nowhere.toml")), &[]).unwrap_err().to_string();
        assert!(error.contains("nowhere.toml"), "{error}");
    }
}
