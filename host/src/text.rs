//! Text that others wrote: names, paths, messages of the system.

use std::borrow::Cow;
use std::fmt::Write;

/// Whether a character is shown as itself everywhere: no control character, no line break of any system, no noncharacter, and none that
/// changes the direction of writing or is invisible (Unicode's `Default_Ignorable_Code_Point` and interlinear annotations; variation
/// selectors after a letter or an emoji are allowed).
pub fn is_printable(c: char) -> bool {
    let hidden = matches!(c,
        '\u{ad}' | '\u{34f}' | '\u{61c}' | '\u{115f}' | '\u{1160}' | '\u{17b4}' | '\u{17b5}' | '\u{180e}'
            | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{3164}' | '\u{feff}' | '\u{ffa0}'
            | '\u{fff0}'..='\u{fffb}' | '\u{1bca0}'..='\u{1bca3}' | '\u{1d173}'..='\u{1d17a}' | '\u{e0000}'..='\u{e00ff}'
            | '\u{e01f0}'..='\u{e0fff}');
    let noncharacter = u32::from(c) & 0xfffe == 0xfffe || matches!(c, '\u{fdd0}'..='\u{fdef}');
    !c.is_control() && !hidden && !noncharacter
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
/// means the same. Those beyond U+FFFF stay: JSON writes them as two surrogates, which YAML does not know.
pub fn printable_json(json: &str) -> Cow<'_, str> {
    let kept = |c| is_printable(c) || c == '\n' || c > '\u{ffff}';
    escaped(json, kept, |out, c| write!(out, "\\u{:04x}", u32::from(c)))
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
        for unseen in
            ['\u{ad}', '\u{61c}', '\u{180e}', '\u{fffa}', '\u{fffe}', '\u{1ffff}', '\u{e0041}', '\u{3164}']
        {
            assert!(!is_printable(unseen), "{unseen:?}");
        }
        for seen in ['é', '中', '\u{fe0f}', '\u{1f4e1}', '\u{fffd}', '\u{301}'] {
            assert!(is_printable(seen), "{seen:?}");
        }
    }

    #[test]
    fn printable_json_is_read_as_before() {
        let text = "ρ\u{85}\u{2028}\u{7f}\u{1f4e1}\u{e0041}\"\n";
        let json = serde_json::to_string(text).unwrap();
        let printable = printable_json(&json);
        assert_eq!(printable, "\"ρ\\u0085\\u2028\\u007f\u{1f4e1}\u{e0041}\\\"\\n\"");
        assert_eq!(serde_json::from_str::<String>(&printable).unwrap(), text);
    }
}
