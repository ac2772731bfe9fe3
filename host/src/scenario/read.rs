//! Reading a scenario: a file or a built-in one, with single fields set over it; every refusal names its origin.

use super::error::ScenarioError;
use super::overrides::Override;
use super::{Scenario, builtin};
use crate::store::limited;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

impl Scenario {
    /// Reads and checks a TOML file.
    ///
    /// # Errors
    ///
    /// See [`ScenarioError`].
    pub fn load(file: &Path) -> Result<Self, ScenarioError> {
        Self::resolve(Some(file), &[])
    }

    /// Reads and checks TOML; errors name `file` as its origin.
    ///
    /// # Errors
    ///
    /// See [`ScenarioError`].
    pub fn parse(text: &str, file: &Path) -> Result<Self, ScenarioError> {
        Self::parse_with(text, file, &[])
    }

    /// As [`Scenario::parse`], with single fields set over it.
    ///
    /// # Errors
    ///
    /// The first thing that is wrong.
    pub fn parse_with(text: &str, file: &Path, set: &[Override]) -> Result<Self, ScenarioError> {
        deserialised(text, file)?.with(set, &file.display().to_string())
    }

    /// A file, or the built-in scenario of that name where there is no such file, or the paper's room; then `set` over it.
    ///
    /// # Errors
    ///
    /// The first thing that is wrong.
    pub fn resolve(file: Option<&Path>, set: &[Override]) -> Result<Self, ScenarioError> {
        let Some(file) = file else { return Self::default().with(set, "built in") };
        Self::parse_with(&text_of(file)?, file, set)
    }

    /// This scenario with single fields set, checked.
    ///
    /// # Errors
    ///
    /// An override that no field takes; a value outside its range, with the override or else `origin` as where it is from.
    pub fn with(self, set: &[Override], origin: &str) -> Result<Self, ScenarioError> {
        let mut scenario = self;
        for one in set {
            scenario = one.apply(&scenario)?;
        }
        match scenario.errors(origin, set).into_iter().next() {
            Some(error) => Err(error),
            None => Ok(scenario),
        }
    }

    /// Everything that is wrong with a file and what is set over it: unreadable lines, unknown keys and wrong types first,
    /// then values outside their ranges. Nothing if it may be used.
    pub fn errors_of(file: &Path, set: &[Override]) -> Vec<ScenarioError> {
        let text = match text_of(file) {
            Ok(text) => text,
            Err(error) => return vec![error],
        };
        let mut errors = Vec::new();
        let mut scenario = match tolerant(&text, file, &mut errors) {
            Some(scenario) => scenario,
            None => return errors,
        };
        for one in set {
            match one.apply(&scenario) {
                Ok(changed) => scenario = changed,
                Err(error) => errors.push(error),
            }
        }
        errors.extend(scenario.errors(&file.display().to_string(), set));
        errors
    }

    /// The resolved scenario as TOML, every default written out.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }
}

/// Most errors of a file that are looked for: each takes another pass over it.
const MOST_ERRORS: usize = 100;

/// Most characters of a line of an error: what quotes a file's line may quote megabytes.
const LONGEST_LINE: usize = 800;

/// The TOML of a file, or of the built-in scenario of that name.
pub(super) fn text_of(file: &Path) -> Result<String, ScenarioError> {
    match (limited::read_text(file, limited::TEXT), builtin::named(file)) {
        (Ok(text), _) => Ok(text),
        (Err(source), Some(built_in)) if source.kind() == std::io::ErrorKind::NotFound => {
            Ok(built_in.toml.to_owned())
        }
        (Err(source), _) => Err(ScenarioError::Read { file: file.to_owned(), source }),
    }
}

fn deserialised(text: &str, file: &Path) -> Result<Scenario, ScenarioError> {
    toml::from_str(text).map_err(|error| syntax(&error, file))
}

fn syntax(error: &toml::de::Error, file: &Path) -> ScenarioError {
    ScenarioError::Syntax { file: file.to_owned(), message: syntax_message(error) }
}

/// What is wrong with a TOML, in lines that fit a terminal: a file's own may be megabytes long.
pub fn syntax_message(error: &toml::de::Error) -> String {
    let said = error.to_string();
    let lines = said.trim_end().lines().map(|line| match line.char_indices().nth(LONGEST_LINE) {
        Some((end, _)) => format!("{}...", &line[..end]),
        None => line.to_owned(),
    });
    lines.collect::<Vec<_>>().join("\n  ")
}

/// What remains of a file without the keys that are in the way, each of which adds an error.
fn tolerant(text: &str, file: &Path, errors: &mut Vec<ScenarioError>) -> Option<Scenario> {
    let mut kept = match DeTable::parse(text) {
        Ok(kept) => kept,
        Err(mut error) => {
            error.set_input(Some(text));
            errors.push(syntax(&error, file));
            return None;
        }
    };
    while errors.len() < MOST_ERRORS {
        let deserializer = toml::de::Deserializer::from(kept.clone());
        let mut error = match serde::Deserialize::deserialize(deserializer) {
            Ok(scenario) => return Some(scenario),
            Err(error) => error,
        };
        let place = error.span();
        error.set_input(Some(text));
        errors.push(syntax(&error, file));
        if !place.is_some_and(|place| remove(kept.get_mut(), &place)) {
            return None;
        }
    }
    let message = format!("{MOST_ERRORS} errors: what follows was not looked at");
    errors.push(ScenarioError::Syntax { file: file.to_owned(), message });
    None
}

/// Takes the innermost key away that is, or holds, the text at `place`.
fn remove(table: &mut DeTable<'_>, place: &std::ops::Range<usize>) -> bool {
    let holds = |key: &Spanned<DeString<'_>>, value: &Spanned<DeValue<'_>>| {
        let around = |span: std::ops::Range<usize>| span.start <= place.start && place.end <= span.end;
        around(key.span()) || around(value.span()) || within(value.get_ref(), place)
    };
    let found = table.iter().find(|(key, value)| holds(key, value)).map(|(key, _)| key.clone());
    let Some(key) = found else { return false };
    if let Some(DeValue::Table(inner)) = table.get_mut(&key).map(Spanned::get_mut)
        && remove(inner, place)
    {
        return true;
    }
    table.remove(&key).is_some()
}

/// Whether a table, placed at its header, has the text at `place` below it.
fn within(value: &DeValue<'_>, place: &std::ops::Range<usize>) -> bool {
    let around = |span: std::ops::Range<usize>| span.start <= place.start && place.end <= span.end;
    match value {
        DeValue::Table(table) => table
            .iter()
            .any(|(key, value)| around(key.span()) || around(value.span()) || within(value.get_ref(), place)),
        DeValue::Array(array) => {
            array.iter().any(|value| around(value.span()) || within(value.get_ref(), place))
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_full_of_errors_is_reported_in_a_few_words() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("s.toml");
        let errors_of = |text: &str| {
            std::fs::write(&file, text).unwrap();
            Scenario::errors_of(&file, &[])
        };
        let unknown = |count: usize| (0..count).map(|k| format!("k{k} = 1\n")).collect::<String>();
        assert_eq!(errors_of(&unknown(99)).len(), 99);
        let many = errors_of(&unknown(50_000));
        assert_eq!(many.len(), MOST_ERRORS + 1);
        assert!(many[MOST_ERRORS].to_string().contains("was not looked at"));
        let long = errors_of(&format!("name = {}", "[".repeat(1 << 20)));
        assert!(long.iter().all(|error| error.to_string().len() < 4 * LONGEST_LINE), "{}", long.len());
    }
}
