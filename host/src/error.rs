//! Why a command fails, and what is wrong with a field.

use std::fmt::{self, Display, Formatter};

/// Any refusal or failure of a command: exit code 2.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// A field with a value that it may not have: `ORIGIN: FIELD is VALUE, must be LEGAL`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct Invalid {
    /// Where the field stands: a file and perhaps a line, `command line`, `environment`; may be empty.
    pub origin: String,
    /// Its name.
    pub field: String,
    /// Its value, or `missing`.
    pub value: String,
    /// The legal values.
    pub legal: String,
}

impl Invalid {
    /// A field to which the caller adds its origin.
    pub fn new(field: impl Display, value: impl Display, legal: impl Display) -> Self {
        let [field, value, legal] = [field.to_string(), value.to_string(), legal.to_string()];
        Invalid { origin: String::new(), field, value, legal }
    }

    /// An option of the command line.
    pub fn option(name: impl Display, value: impl Display, legal: impl Display) -> Self {
        Invalid::new(name, value, legal).at("command line")
    }

    /// The same within `origin`, which is put before what is known of it.
    #[must_use]
    pub fn at(mut self, origin: impl Display) -> Self {
        let inner = std::mem::take(&mut self.origin);
        self.origin = if inner.is_empty() { origin.to_string() } else { format!("{origin}, {inner}") };
        self
    }

    /// Refuses a value unless it is legal.
    ///
    /// # Errors
    ///
    /// The field, its value and the legal ones.
    pub fn unless(
        holds: bool,
        field: impl Display,
        value: impl Display,
        legal: impl Display,
    ) -> Result<(), Self> {
        if holds { Ok(()) } else { Err(Invalid::new(field, value, legal)) }
    }
}

impl Display for Invalid {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let Invalid { origin, field, value, legal } = self;
        let separator = if origin.is_empty() { "" } else { ": " };
        write!(f, "{origin}{separator}{field} is {value}, must be {legal}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_message_names_origin_field_value_and_legal_values() {
        let inner = Invalid::new("rho", 1.5, "0 to 1");
        assert_eq!(inner.to_string(), "rho is 1.5, must be 0 to 1");
        assert_eq!(
            inner.at("line 3").at("room.toml").to_string(),
            "room.toml, line 3: rho is 1.5, must be 0 to 1"
        );
    }
}
