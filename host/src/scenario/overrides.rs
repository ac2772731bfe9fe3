//! Single fields set over a scenario, as `--set radar.carrier_hz=60e9` does.

use super::{Scenario, ScenarioError};
use crate::error::Invalid;
use std::str::FromStr;
use toml::{Table, Value};

/// A field, and the value it is given.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    field: String,
    value: Value,
}

impl FromStr for Override {
    type Err = String;

    /// `FIELD=VALUE`: a dotted field, a TOML value; words need no quotes.
    fn from_str(text: &str) -> Result<Self, String> {
        let legal = "FIELD=VALUE, such as radar.carrier_hz=60e9 or frame.sensing_slots=[200,300]";
        let (field, value) = text.split_once('=').ok_or_else(|| format!("expected {legal}"))?;
        let (field, value) = (field.trim(), value.trim());
        if field.is_empty() || value.is_empty() {
            return Err(format!("expected {legal}"));
        }
        let parsed = toml::from_str::<Table>(&format!("value = {value}"));
        let parsed = parsed.ok().and_then(|mut table| table.remove("value"));
        let value = parsed.unwrap_or_else(|| Value::String(value.to_owned()));
        Ok(Override { field: field.to_owned(), value })
    }
}

impl Override {
    /// Whether it set this field, or the list or table the field is in.
    pub fn sets(&self, field: &str) -> bool {
        let rest = field.strip_prefix(&self.field);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[', ' ']))
    }

    /// The scenario with this field set; its range is not looked at.
    ///
    /// # Errors
    ///
    /// No such field, or a value of another type.
    pub fn apply(&self, scenario: &Scenario) -> Result<Scenario, ScenarioError> {
        let refusal = |legal: String| Invalid::new(&self.field, &self.value, legal).at(ORIGIN);
        let mut whole = Table::try_from(scenario).map_err(|e| refusal(e.to_string()))?;
        let (path, last) = self.field.rsplit_once('.').unwrap_or(("", &self.field));
        let mut table = &mut whole;
        for key in path.split('.').filter(|key| !key.is_empty()) {
            let inner = table.get_mut(key).and_then(Value::as_table_mut);
            table = inner.ok_or_else(|| refusal("a field that `sdp3 scenario show` lists".to_owned()))?;
        }
        table.insert(last.to_owned(), self.value.clone());
        whole.try_into().map_err(|error: toml::de::Error| {
            // "unknown field `carier_hz`, expected one of ...", "invalid type: string, expected f64"
            let (wrong, expected) = error.message().split_once("expected ").unwrap_or(("", error.message()));
            let value = if wrong.starts_with("unknown field") { "no field" } else { &self.value.to_string() };
            Invalid::new(&self.field, value, expected).at(ORIGIN).into()
        })
    }
}

/// Where the value of an override is from.
pub(super) const ORIGIN: &str = "command line: --set";

#[cfg(test)]
mod tests {
    use super::*;

    fn set(text: &str) -> Result<Scenario, ScenarioError> {
        Scenario::default().with(&[text.parse().expect("a field and a value")], "built in")
    }

    #[test]
    fn fields_of_every_kind_are_set() {
        let scenario = set("frame.sensing_slots=[200, 300]").unwrap();
        assert_eq!(scenario.frame.sensing_slots, [200, 300]);
        assert_eq!(set("radar.carrier_hz=60e9").unwrap().radar.carrier_hz, 60e9);
        assert_eq!(set("radar.power_w=2").unwrap().radar.power_w, 2.0);
        assert_eq!(set("channel.rho=0.5").unwrap().channel.rho, Some(0.5));
        assert_eq!(set("channel.model=ray-tracing").unwrap().channel.model.name(), "ray-tracing");
        assert_eq!(set("name=my room").unwrap().name, "my room");
    }

    #[test]
    fn refusals_name_the_field_and_say_what_is_legal() {
        let refused = |text: &str, words: &[&str]| {
            let error = set(text).unwrap_err().to_string();
            for word in words.iter().chain(&[ORIGIN]) {
                assert!(error.contains(word), "{text}: {word} is not in: {error}");
            }
        };
        refused("radar.carier_hz=1e9", &["radar.carier_hz", "carrier_hz"]);
        refused("radr.carrier_hz=1e9", &["radr.carrier_hz", "sdp3 scenario show"]);
        refused("radar.carrier_hz=fast", &["radar.carrier_hz", "fast", "f64"]);
        refused("channel.rho=1.5", &["channel.rho is 1.5", "0 to 1"]);
        refused("communication.cases=[[[9.0, 1.0, 1.0]]]", &["communication.cases[0][0]", "inside the room"]);
        assert!("channel.rho".parse::<Override>().unwrap_err().contains("FIELD=VALUE"));
    }
}
