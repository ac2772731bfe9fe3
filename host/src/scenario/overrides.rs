//! Single fields set over a scenario, as `--set radar.carrier_hz=60e9` does.

use super::{Scenario, ScenarioError};
use crate::error::Invalid;
use std::str::FromStr;
use toml::{Table, Value};

/// A field, and the value it is given, as typed.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    field: String,
    value: String,
}

impl FromStr for Override {
    type Err = String;

    /// `FIELD=VALUE`: a dotted field, a value of the field's type; text needs no quotes.
    fn from_str(text: &str) -> Result<Self, String> {
        let legal = "FIELD=VALUE, such as radar.carrier_hz=60e9 or frame.sensing_slots=[200,300]";
        let (field, value) = text.split_once('=').ok_or_else(|| format!("expected {legal}"))?;
        let (field, value) = (field.trim(), value.trim());
        if field.is_empty() || value.is_empty() {
            return Err(format!("expected {legal}"));
        }
        Ok(Override { field: field.to_owned(), value: value.to_owned() })
    }
}

impl Override {
    /// A field and its value.
    pub(super) fn new(field: &str, value: impl ToString) -> Self {
        Override { field: field.to_owned(), value: value.to_string() }
    }

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
        let parsed = toml::from_str::<Table>(&format!("value = {}", self.value));
        let parsed = parsed.ok().and_then(|mut table| table.remove("value"));
        let text = Value::String(self.value.clone());
        let first = self.placed(scenario, parsed.unwrap_or_else(|| text.clone()))?.try_into();
        // a field of text takes what is no text in TOML, such as the channel model 38901
        first.or_else(|error: toml::de::Error| {
            let refusal = || match scenario.legal_values(&self.field) {
                Some(legal) => self.refusal(legal),
                None => self.refusal_of(error.message()),
            };
            self.placed(scenario, text)?.try_into().map_err(|_: toml::de::Error| refusal())
        })
    }

    /// The scenario as a table with this value in the field's place.
    fn placed(&self, scenario: &Scenario, value: Value) -> Result<Table, ScenarioError> {
        let mut whole = Table::try_from(scenario).map_err(|e| self.refusal(e.to_string()))?;
        let (path, last) = self.field.rsplit_once('.').unwrap_or(("", &self.field));
        let mut table = &mut whole;
        for key in path.split('.').filter(|key| !key.is_empty()) {
            let inner = table.get_mut(key).and_then(Value::as_table_mut);
            table =
                inner.ok_or_else(|| self.refusal("a field that `sdp3 scenario show` lists".to_owned()))?;
        }
        table.insert(last.to_owned(), value);
        Ok(whole)
    }

    fn refusal(&self, legal: String) -> ScenarioError {
        Invalid::new(&self.field, &self.value, legal).at(ORIGIN).into()
    }

    /// What serde says: "unknown field `carier_hz`, expected one of ...", "invalid type: string, expected f64".
    fn refusal_of(&self, message: &str) -> ScenarioError {
        let (wrong, expected) = message.split_once("expected ").unwrap_or(("", message));
        let value = if wrong.starts_with("unknown field") { "no field" } else { &self.value };
        Invalid::new(&self.field, value, expected).at(ORIGIN).into()
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
        // text that is a number or a truth value in TOML
        assert_eq!(set("channel.model=38901").unwrap().channel.model.name(), "38901");
        assert_eq!(set("channel.model=\"38901\"").unwrap().channel.model.name(), "38901");
        assert_eq!(set("name=2024-05-01").unwrap().name, "2024-05-01");
        assert_eq!(set("name=true").unwrap().name, "true");
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
        refused("radar.carrier_hz=fast", &["radar.carrier_hz is fast", "a number, 500000000 to 1"]);
        refused("channel.model=38902", &["channel.model is 38902", "one of dahc, ", "38901, quadriga"]);
        refused("radar.left_justified=1", &["radar.left_justified is 1", "true or false"]);
        refused("learning.blocks=2.5", &["learning.blocks is 2.5", "a whole number, 1 to 8"]);
        refused("learning.blocks=300", &["learning.blocks is 300", "a whole number, 1 to 8"]);
        refused("room.size_m=[3, x]", &["room.size_m is [3, x]", "an array of length 3"]);
        refused("channel.rho=1.5", &["channel.rho is 1.5", "0 to 1"]);
        refused("communication.cases=[[[9.0, 1.0, 1.0]]]", &["communication.cases[0][0]", "inside the room"]);
        assert!("channel.rho".parse::<Override>().unwrap_err().contains("FIELD=VALUE"));
    }
}
