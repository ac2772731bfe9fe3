//! The JSON Schema of a scenario: types and descriptions from the fields, legal ranges from the rules.

use super::Scenario;
use super::rules::legal_words;
use serde_json::{Map, Value, json};

impl Scenario {
    /// JSON Schema (2020-12) of a scenario. `x-legal` holds a field's legal range in words, for the paper's room where
    /// another field bounds it.
    pub fn schema() -> Value {
        let mut schema = schemars::schema_for!(Scenario).to_value();
        let rules = Scenario::default().rules();
        for rule in &rules {
            let Some(field) = field_mut(&mut schema, rule.base()) else { continue };
            field.insert("x-legal".into(), json!(legal_words(&rules, rule.base())));
            let [low, high] = match rule.bounds {
                Some(bounds) => bounds.map(|bound| json!(bound)),
                None => continue,
            };
            let (least, most) = match rule.part() {
                "" => ("minimum", "maximum"),
                "how many" => ("minItems", "maxItems"),
                _ => continue,
            };
            field.insert(least.into(), whole(low));
            field.insert(most.into(), whole(high));
        }
        schema
    }

    /// What a field means and which names it takes, by its dotted name; empty where nothing is known.
    pub(super) fn meaning(schema: &Value, field: &str) -> (String, Vec<String>) {
        let Some(found) = field_of(schema, field) else { return Default::default() };
        let words = found.get("description").and_then(Value::as_str).unwrap_or_default();
        let names = followed(schema, found).get("oneOf").and_then(Value::as_array);
        let name = |one: &Value| one.get("const").and_then(Value::as_str).map(str::to_owned);
        (words.replace('\n', " "), names.into_iter().flatten().filter_map(name).collect())
    }

    /// Which values a field takes, in words; `None` if there is no such field, or for a list.
    pub(super) fn legal_values(&self, field: &str) -> Option<String> {
        let schema = Scenario::schema();
        let found = field_of(&schema, field)?;
        let (_, names) = Scenario::meaning(&schema, field);
        if !names.is_empty() {
            return Some(format!("one of {}", names.join(", ")));
        }
        let kind = found.get("type")?;
        // of a field that may be absent the first of two types
        let kind = match kind.as_str().or_else(|| kind.get(0)?.as_str())? {
            "number" => "a number",
            "integer" => "a whole number",
            "boolean" => "true or false",
            _ => return None,
        };
        let words = [kind.to_owned(), legal_words(&self.rules(), field)];
        Some(words.into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>().join(", "))
    }
}

/// A number without a fraction where it has none.
fn whole(number: Value) -> Value {
    match number.as_f64() {
        Some(n) if n.fract() == 0.0 && n.abs() < 9e15 => json!(n as i64),
        _ => number,
    }
}

/// What a schema refers to, or itself.
fn followed<'a>(root: &'a Value, schema: &'a Value) -> &'a Value {
    let target = schema.get("$ref").and_then(Value::as_str).and_then(|name| name.strip_prefix('#'));
    target.and_then(|name| root.pointer(name)).unwrap_or(schema)
}

fn pointer(root: &Value, field: &str) -> Option<String> {
    let (mut at, mut found) = (String::new(), root);
    for key in field.split('.') {
        if let Some(name) = found.get("$ref").and_then(Value::as_str) {
            at = name.strip_prefix('#')?.to_owned();
        }
        at += &format!("/properties/{key}");
        found = root.pointer(&at)?;
    }
    Some(at)
}

fn field_of<'a>(root: &'a Value, field: &str) -> Option<&'a Value> {
    root.pointer(&pointer(root, field)?)
}

fn field_mut<'a>(root: &'a mut Value, field: &str) -> Option<&'a mut Map<String, Value>> {
    let pointer = pointer(root, field)?;
    root.pointer_mut(&pointer)?.as_object_mut()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rule_is_in_the_schema_and_every_bound_is_the_one_checked() {
        let schema = Scenario::schema();
        for rule in Scenario::default().rules() {
            let field = field_of(&schema, rule.base()).unwrap_or_else(|| panic!("{}", rule.field));
            assert!(
                field["x-legal"].as_str().is_some_and(|legal| legal.contains(&rule.legal)),
                "{}",
                rule.field
            );
            let ([Some(low), Some(high)], "") =
                (["minimum", "maximum"].map(|k| field[k].as_f64()), rule.part())
            else {
                continue;
            };
            // just outside is refused, the bound itself is not
            let outside = 1e-3 * (high - low);
            let integer = field["type"] == "integer";
            let outside = if integer { 1.0 } else { outside };
            for (value, legal) in [(low, true), (high, true), (low - outside, false), (high + outside, false)]
            {
                if integer && value < 0.0 {
                    continue;
                }
                let set = format!("{}={value:?}", rule.field);
                let set = if integer { set.trim_end_matches(".0").to_owned() } else { set };
                let Ok(changed) = set.parse::<super::super::Override>().unwrap().apply(&Scenario::default())
                else {
                    // too large for its type, which is refused as well
                    assert!(!legal, "{set}");
                    continue;
                };
                let mut held =
                    changed.rules().into_iter().filter(|r| r.field == rule.field && r.bounds.is_some());
                assert!(held.all(|r| r.holds == legal), "{set}");
            }
        }
    }

    #[test]
    fn fields_have_words_and_names() {
        let schema = Scenario::schema();
        let (words, names) = Scenario::meaning(&schema, "channel.model");
        assert!(words == "Which model." && names.contains(&"80211ay".to_owned()), "{words} {names:?}");
        assert_eq!(Scenario::meaning(&schema, "radar.power_w").0, "Transmit power in W.");
    }
}
