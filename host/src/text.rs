//! Text that others wrote: names, paths, messages of the system.

use std::borrow::Cow;
use std::fmt::Write;

/// Whether a character is shown as itself everywhere: no control character, no line break of any system, none that turns the direction of
/// writing or has no width.
pub fn is_printable(c: char) -> bool {
    let hidden =
        matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}');
    !c.is_control() && !hidden
}

/// Text for a terminal: every character that is not printable as `\u{1b}`, but for line breaks and tabs.
pub fn shown(text: &str) -> Cow<'_, str> {
    escaped(
        text,
        |c| is_printable(c) || matches!(c, '\n' | '\t'),
        |out, c| write!(out, "{}", c.escape_unicode()),
    )
}

/// JSON with every character that is not printable, which can only stand in a string, as `\u001b`: a terminal shows it, and as YAML it
/// means the same.
pub fn printable_json(json: &str) -> Cow<'_, str> {
    escaped(json, |c| is_printable(c) || c == '\n', |out, c| write!(out, "\\u{:04x}", u32::from(c)))
}

fn escaped(
    text: &str,
    kept: impl Fn(char) -> bool,
    escape: impl Fn(&mut String, char) -> std::fmt::Result,
) -> Cow<'_, str> {
    if text.chars().all(&kept) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        // a string takes everything
        let _ = if kept(c) { out.write_char(c) } else { escape(&mut out, c) };
    }
    Cow::Owned(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminals_get_no_control_characters() {
        assert_eq!(shown("ρ = 0.9\n\ta"), "ρ = 0.9\n\ta");
        assert_eq!(shown("a\u{1b}[31mb\u{9b}\rc\u{202e}"), "a\\u{1b}[31mb\\u{9b}\\u{d}c\\u{202e}");
    }

    #[test]
    fn printable_json_is_read_as_before() {
        let text = "ρ\u{85}\u{2028}\u{7f}\u{1f4e1}\"\n";
        let json = serde_json::to_string(text).unwrap();
        let printable = printable_json(&json);
        assert_eq!(printable, "\"ρ\\u0085\\u2028\\u007f\u{1f4e1}\\\"\\n\"");
        assert_eq!(serde_json::from_str::<String>(&printable).unwrap(), text);
    }
}
