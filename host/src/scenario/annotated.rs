//! A scenario as TOML that explains itself: over every field what it means, its unit and its legal range.

use super::Scenario;
use super::rules::legal_words;
use std::fmt::Write;

/// Widest line of a comment.
const COLUMNS: usize = 110;

impl Scenario {
    /// The resolved scenario as TOML with comments; read again it is the same scenario.
    pub fn to_commented_toml(&self) -> String {
        let schema = Scenario::schema();
        let rules = self.rules();
        let mut text = String::new();
        let mut section = String::new();
        for line in self.to_toml().lines() {
            let header = line.trim_start_matches('[').trim_end_matches(']');
            let key = line.split_once(" = ").map(|(key, _)| key).filter(|key| !key.contains(['"', '[', ' ']));
            if line.starts_with('[') && line.ends_with(']') && !line.contains(',') {
                section = header.to_owned() + ".";
                comment(&mut text, &Scenario::meaning(&schema, header).0);
            } else if let Some(key) = key {
                let field = format!("{section}{key}");
                let (mut words, names) = Scenario::meaning(&schema, &field);
                let legal = legal_words(&rules, &field);
                let legal = if names.is_empty() { legal } else { format!("one of {}", names.join(", ")) };
                if !legal.is_empty() {
                    let _ = write!(words, " Legal: {legal}.");
                }
                comment(&mut text, &words);
            }
            text += line;
            text.push('\n');
        }
        text
    }
}

/// Adds a comment, wrapped between words.
fn comment(text: &mut String, words: &str) {
    let mut width = COLUMNS;
    for word in words.split_whitespace() {
        if width + word.len() + 1 > COLUMNS {
            if !text.is_empty() && !text.ends_with('\n') {
                text.push('\n');
            }
            text.push('#');
            width = 1;
        }
        text.push(' ');
        text.push_str(word);
        width += word.len() + 1;
    }
    if !words.trim().is_empty() {
        text.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::super::builtin::ALL;
    use super::*;

    #[test]
    fn every_field_is_explained_and_the_scenario_survives() {
        for one in &ALL {
            let scenario = one.scenario();
            let text = scenario.to_commented_toml();
            assert_eq!(toml::from_str::<Scenario>(&text).unwrap(), scenario, "{}", one.name);
            let mut before = "";
            for line in text.lines() {
                assert!(line.len() <= COLUMNS || !line.starts_with('#'), "{line}");
                let plain = !line.starts_with(['#', '[', ' ', ']']) && !line.is_empty();
                let listed = ["class =", "start_m =", "centre_m =", "cross_section_dbsm ="];
                let other = listed.iter().any(|field| line.contains(field));
                assert!(!plain || other || before.starts_with('#'), "{}: {line}", one.name);
                before = line;
            }
        }
        let text = Scenario::default().to_commented_toml();
        assert!(
            text.contains("# Transmit power in W. Legal: 0.000000000001 to 1000.\npower_w = 1.0"),
            "{text}"
        );
        assert!(text.contains("N_s must fill four windows"), "{text}");
    }
}
