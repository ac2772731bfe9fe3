//! Scenarios that come with the tool, by name; each is a file that states what differs from the paper's room.

use super::Scenario;
use std::path::Path;

/// A scenario that comes with the tool.
#[derive(Debug, Clone, Copy)]
pub struct BuiltIn {
    /// Its name, which `--scenario` takes in place of a file.
    pub name: &'static str,
    /// Its TOML; the comment it begins with says what it is for.
    pub toml: &'static str,
}

macro_rules! built_in {
    ($($name:literal),+ $(,)?) => {
        [$(BuiltIn { name: $name, toml: include_str!(concat!("../../scenarios/", $name, ".toml")) }),+]
    };
}

/// All of them, the paper's room first.
pub const ALL: [BuiltIn; 11] = built_in![
    "conference-room",
    "as-printed",
    "second-person",
    "small-radar",
    "child-safe-room",
    "busy-office",
    "radar-24ghz",
    "radar-60ghz",
    "doppler-24ghz",
    "bgt60",
    "iwr",
];

impl BuiltIn {
    /// What it is for, in a line.
    pub fn about(&self) -> String {
        let comment = self.toml.lines().map_while(|line| line.strip_prefix('#'));
        comment.map(str::trim).collect::<Vec<_>>().join(" ")
    }

    /// The scenario; a test reads every one.
    pub fn scenario(&self) -> Scenario {
        toml::from_str(self.toml).unwrap_or_default()
    }
}

/// The built-in scenario of this name.
pub fn named(name: &Path) -> Option<&'static BuiltIn> {
    ALL.iter().find(|built_in| Path::new(built_in.name) == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::validity::aliasing;

    #[test]
    fn every_one_is_legal_unlike_the_others_and_does_not_alias() {
        let mut seen: Vec<Scenario> = Vec::new();
        for one in &ALL {
            let scenario = Scenario::parse(one.toml, Path::new(one.name)).unwrap();
            assert_eq!((scenario.name.as_str(), &scenario), (one.name, &one.scenario()));
            assert_eq!(aliasing(&scenario, &crate::scenario::Class::ALL), None, "{}", one.name);
            assert!(one.about().len() > 20, "{}", one.name);
            let unnamed = Scenario { name: String::new(), ..scenario };
            assert!(!seen.contains(&unnamed), "{} is another", one.name);
            seen.push(unnamed);
        }
        assert_eq!(ALL[0].scenario(), Scenario::default());
    }
}
