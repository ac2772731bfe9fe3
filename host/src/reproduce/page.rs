//! The results as one page in Markdown, and the result files that it is made of.

use super::Item;
use crate::error::{Failure, Invalid};
use crate::results::{Compared, Estimate, Reproduction, Statement};
use crate::store::limited;
use clap::ValueEnum;
use std::fmt::Write;
use std::path::Path;

/// Name of the page.
pub const PAGE: &str = "reproduction.md";

/// The results of a folder, in the paper's order.
///
/// # Errors
///
/// A file that is missing or damaged; results of different sizes or sets of seeds.
pub fn read(folder: &Path) -> Result<Vec<Reproduction>, Failure> {
    let file = |item: &Item| -> Result<Reproduction, Failure> {
        let path = folder.join(format!("{}.json", item.name()));
        let named = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let bytes = limited::read(&path, limited::RESULT).map_err(|error| named(&error))?;
        Ok(serde_json::from_slice(&bytes).map_err(|error| named(&error))?)
    };
    let found = Item::value_variants().iter().map(file).collect::<Result<Vec<_>, _>>()?;
    same(&found)?;
    Ok(found)
}

/// Refuses results that do not belong together.
///
/// # Errors
///
/// The first that differs from the first of all.
pub fn same(all: &[Reproduction]) -> Result<(), Failure> {
    let Some(first) = all.first() else { return Ok(()) };
    for other in all {
        for (field, value, expected) in [
            ("size", &other.size, &first.size),
            ("seed_set", &other.seed_set, &first.seed_set),
            ("seeds", &format!("{:?}", other.seeds), &format!("{:?}", first.seeds)),
        ] {
            let legal = format!("{expected}, as of {}", first.item);
            Invalid::unless(value == expected, field, value, legal)
                .map_err(|invalid| invalid.at(format!("{}.json", other.item)))?;
        }
    }
    Ok(())
}

fn digits(x: f64) -> String {
    match x.abs() {
        size if size == 0.0 || size >= 100.0 => format!("{x:.0}"),
        size if size >= 10.0 => format!("{x:.2}"),
        size if size >= 0.01 => format!("{x:.4}"),
        _ => format!("{x:.3e}"),
    }
}

fn estimate(found: Option<Estimate>) -> String {
    match found {
        None => "–".into(),
        Some(e) if e.low == e.high => digits(e.mean),
        Some(e) => format!("{} [{}, {}]", digits(e.mean), digits(e.low), digits(e.high)),
    }
}

fn row(n: &Compared) -> String {
    let paper = n.paper.map_or_else(|| "–".into(), digits);
    format!("| {} | {paper} | {} | {} |\n", n.quantity, estimate(n.as_printed), estimate(n.here))
}

fn line(s: &Statement) -> String {
    let word = |holds: Option<bool>| match holds {
        Some(true) => "true",
        Some(false) => "**false**",
        None => "–",
    };
    format!("| {} | {} | {} |\n", s.text, word(s.as_printed), word(s.here))
}

/// The page; figures lie in `folder`, seen from it.
pub fn page(all: &[Reproduction], folder: &str) -> String {
    let Some(first) = all.first() else { return String::new() };
    let seeds: Vec<String> = first.seeds.iter().map(u64::to_string).collect();
    let mut text = format!(
        "# The paper, figure by figure\n\nEvery table and figure of the paper, made again by `sdp3 reproduce --size {} --seed {} --seeds {}`: \
         with the settings as printed (its room that fades while it is recorded, its training) and with those of this tool. Seeds: {} \
         ({}). Intervals are of 95 %.\n\nReproduced: every number of the paper lies in its interval, every statement is true. In order only: \
         the statements are true. The file of each item is in [{folder}]({folder}).\n\n| item | as printed | here |\n|---|---|---|\n",
        first.size,
        first.seeds[0],
        seeds.len(),
        seeds.join(", "),
        first.seed_set,
    );
    for r in all {
        let anchor = r.item.clone();
        let _ = writeln!(text, "| [{}](#{anchor}) | {} | {} |", r.caption, r.verdict_as_printed, r.verdict);
    }
    for r in all {
        let _ = write!(
            text,
            "\n## {}\n\n{}. As printed: **{}**. Here: **{}**.\n",
            r.item, r.caption, r.verdict_as_printed, r.verdict
        );
        for figure in &r.figures {
            let _ = write!(text, "\n![{}]({folder}/{figure}.svg)\n", r.caption);
        }
        if !r.statements.is_empty() {
            text += "\n| statement of the paper | as printed | here |\n|---|---|---|\n";
            r.statements.iter().for_each(|s| text += &line(s));
        }
        if !r.numbers.is_empty() {
            text += "\n| quantity | the paper | as printed | here |\n|---|---|---|---|\n";
            r.numbers.iter().for_each(|n| text += &row(n));
        }
        if !r.notes.is_empty() {
            text.push('\n');
            r.notes.iter().for_each(|note| text += &format!("- {note}\n"));
        }
    }
    text
}
