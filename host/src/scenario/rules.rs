//! Rules as data: what is checked is also what `sdp3 scenario show` and the schema print.

/// One rule for a value.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Dotted name of the field; what of it is meant, if not all, in brackets behind.
    pub field: String,
    /// The value.
    pub value: String,
    /// The legal range, in words.
    pub legal: String,
    /// Least and greatest legal number, if they depend on no other field.
    pub bounds: Option<[f64; 2]>,
    /// Whether the value is legal.
    pub holds: bool,
}

/// Rules in the order they are looked at.
#[derive(Debug, Default)]
pub(super) struct Rules {
    pub(super) list: Vec<Rule>,
}

impl Rules {
    pub(super) fn legal(&mut self, field: &str, value: impl std::fmt::Display, holds: bool, legal: &str) {
        let (field, value, legal) = (field.to_owned(), value.to_string(), legal.to_owned());
        self.list.push(Rule { field, value, legal, bounds: None, holds });
    }

    /// A number between bounds that depend on no other field.
    pub(super) fn within(&mut self, field: &str, value: f64, low: f64, high: f64) {
        self.legal(field, value, (low..=high).contains(&value), &range(low, high));
        if let Some(rule) = self.list.last_mut() {
            rule.bounds = Some([low, high]);
        }
    }

    /// The same for a count.
    pub(super) fn count(&mut self, field: &str, value: u32, low: u32, high: u32) {
        self.within(field, f64::from(value), f64::from(low), f64::from(high));
    }

    /// A number between bounds of which one is the value of another field, `legal` in words.
    pub(super) fn beside(&mut self, field: &str, value: f64, [low, high]: [f64; 2], legal: &str) {
        self.legal(field, value, (low..=high).contains(&value), &format!("{}, {legal}", range(low, high)));
    }

    pub(super) fn interval(&mut self, field: &str, value: &[f64; 2], low: f64, high: f64) {
        let [a, b] = *value;
        let holds = (low..=high).contains(&a) && (a..=high).contains(&b);
        self.legal(field, format!("{value:?}"), holds, &format!("[a, b] with {low} <= a <= b <= {high}"));
    }

    pub(super) fn ground(&mut self, field: &str, point: &[f64; 2], room: &[f64; 3]) {
        let holds = point.iter().zip(room).all(|(p, size)| (0.0..=*size).contains(p));
        self.legal(
            field,
            format!("{point:?}"),
            holds,
            &format!("inside the room [0, 0] to {:?}", &room[..2]),
        );
    }

    pub(super) fn inside(&mut self, field: &str, position: &[f64; 3], room: &[f64; 3]) {
        let holds = position.iter().zip(room).all(|(p, size)| (0.0..=*size).contains(p));
        self.legal(field, format!("{position:?}"), holds, &format!("inside the room [0, 0, 0] to {room:?}"));
    }
}

/// A range in words; one with a single legal value says so.
fn range(low: f64, high: f64) -> String {
    if low == high { format!("{low} (fixed)") } else { format!("{low} to {high}") }
}

impl Rule {
    /// The field's name without index and part.
    pub fn base(&self) -> &str {
        self.field.split(['[', ' ']).next().unwrap_or_default()
    }

    /// What of the field is meant: `how many`, an axis, each entry, a field of each entry; empty if all.
    pub fn part(&self) -> &str {
        match self.field.split_once('(') {
            Some((_, part)) => part.trim_end_matches(')'),
            None if self.field.contains('[') => {
                self.field.split_once("].").map_or("each", |(_, of_entry)| of_entry)
            }
            None => "",
        }
    }
}

/// The legal range of a field in words, all its rules together.
pub(super) fn legal_words(rules: &[Rule], base: &str) -> String {
    let mut words: Vec<String> = Vec::new();
    for rule in rules.iter().filter(|rule| rule.base() == base) {
        let said = match rule.part() {
            "" => rule.legal.clone(),
            part => format!("{part}: {}", rule.legal),
        };
        if !words.contains(&said) {
            words.push(said);
        }
    }
    words.join("; ")
}
