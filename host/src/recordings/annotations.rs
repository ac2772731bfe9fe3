//! Annotations of SigMF recordings of raw slots: labels to learn from, and classes that were recognised.
//!
//! `core:sample_start` and `core:sample_count` count samples; `sdp3:slot_samples` and `sdp3:slot_rate` of the global object make them slots
//! and seconds.

use crate::error::{Failure, Invalid};
use crate::results::ClassifiedWindow;
use crate::store::limited;
use serde_json::{Value, json};
use std::path::Path;

/// A labelled part of a recording, in s.
#[derive(Debug, Clone, PartialEq)]
pub struct Annotation {
    pub label: String,
    pub span_s: (f64, f64),
}

/// A recording's description.
struct Meta {
    text: Value,
    /// Samples of a slot.
    slot_samples: u64,
    /// Slots a second.
    slot_rate_hz: f64,
}

/// The description of a recording by the name of either of its files; `None` where it has no raw slots.
fn meta(path: &Path) -> Result<Option<Meta>, Failure> {
    let path = path.with_extension("sigmf-meta");
    let named = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let text = limited::read_text(&path, limited::TEXT).map_err(|e| named(&e))?;
    let text: Value = serde_json::from_str(&text).map_err(|e| named(&e))?;
    let global = |field: &str| text["global"].get(field).cloned().unwrap_or_default();
    let (samples, rate) = (global("sdp3:slot_samples").as_u64(), global("sdp3:slot_rate").as_f64());
    let (Some(slot_samples @ 1..), Some(slot_rate_hz)) = (samples, rate) else { return Ok(None) };
    Ok(Some(Meta { text, slot_samples, slot_rate_hz }))
}

/// The labelled parts of a recording, in the order of its annotations; none where it has no raw slots.
///
/// # Errors
///
/// A description that is not readable; a label without its samples.
pub fn read(path: &Path) -> Result<Vec<Annotation>, Failure> {
    let Some(Meta { text, slot_samples, slot_rate_hz }) = meta(path)? else { return Ok(Vec::new()) };
    let annotations = text["annotations"].as_array().cloned().unwrap_or_default();
    let labelled =
        annotations.iter().enumerate().filter_map(|(n, a)| Some((n, a, a["core:label"].as_str()?)));
    labelled
        .map(|(n, annotation, label)| {
            let samples = |field: &str| {
                annotation[field].as_u64().ok_or_else(|| -> Failure {
                    let value = annotation.get(field).map_or("missing".into(), Value::to_string);
                    let origin = format!("annotation {n}");
                    Invalid::new(field, value, "a whole number").at(origin).at(path.display()).into()
                })
            };
            let (first, count) = (samples("core:sample_start")?, samples("core:sample_count")?);
            let second = |sample: u64| sample as f64 / slot_samples as f64 / slot_rate_hz;
            let span_s = (second(first), second(first.saturating_add(count)));
            Ok(Annotation { label: label.to_owned(), span_s })
        })
        .collect()
}

/// The description of a recording with its windows as its annotations, each over the slots that it used.
///
/// # Errors
///
/// A recording of another format than SigMF, or a description that is not readable.
pub fn annotated(path: &Path, windows: &[ClassifiedWindow]) -> Result<String, Failure> {
    let sigmf = path.extension().is_some_and(|ending| ending.to_string_lossy().starts_with("sigmf"));
    let Some(Meta { mut text, slot_samples, .. }) = (if sigmf { meta(path)? } else { None }) else {
        return Err(Invalid::option(
            "--format",
            "sigmf",
            format!("of a SigMF recording, not {}", path.display()),
        )
        .into());
    };
    let annotation = |window: &ClassifiedWindow| {
        json!({
            "core:sample_start": u64::from(window.first_slot) * slot_samples,
            "core:sample_count": u64::from(window.slots_used) * slot_samples,
            "core:label": window.class,
            "core:generator": crate::PROGRAM,
            "core:comment": format!("confidence {:.3}", window.confidence),
        })
    };
    text["annotations"] = windows.iter().map(annotation).collect();
    Ok(serde_json::to_string_pretty(&text)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_come_back_as_labels() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.sigmf-meta");
        let global = r#"{"global": {"sdp3:slot_samples": 1000, "sdp3:slot_rate": 500.0, "core:author": "me"}, "captures": []}"#;
        std::fs::write(&path, global).unwrap();
        assert_eq!(read(&path).unwrap(), []);
        let window = |first_slot, class: &str| ClassifiedWindow {
            first_slot,
            start_s: 0.0,
            slots_used: 100,
            faulty_slots: None,
            class: class.into(),
            confidence: 0.9,
            logits: Vec::new(),
        };
        let text = annotated(&path, &[window(0, "sit"), window(250, "fall")]).unwrap();
        assert!(text.contains("\"core:author\": \"me\""));
        std::fs::write(&path, text).unwrap();
        let found = read(&folder.path().join("a.sigmf-data")).unwrap();
        let expected = [("sit", (0.0, 0.2)), ("fall", (0.5, 0.7))];
        assert_eq!(found.len(), 2);
        for (found, (label, span_s)) in found.iter().zip(expected) {
            assert_eq!((found.label.as_str(), found.span_s), (label, span_s));
        }
        assert!(annotated(&folder.path().join("a.wav"), &[]).unwrap_err().to_string().contains("--format"));
        std::fs::write(
            &path,
            global.replace("[]", r#"[], "annotations": [{"core:label": "x", "core:sample_start": -1}]"#),
        )
        .unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("annotation 0: core:sample_start is -1"));
    }
}
