//! What an item is made of before it is judged.

use crate::results::{Compared, Estimate, Statement};

/// What an item is made of: its caption, numbers, statements, notes, and panels of its figure with their captions.
#[derive(Debug, Default)]
pub struct Made {
    pub caption: &'static str,
    pub numbers: Vec<Compared>,
    pub statements: Vec<Statement>,
    pub notes: Vec<String>,
    /// `(caption, picture)`, and how many stand side by side.
    pub panels: Vec<(String, String)>,
    pub columns: usize,
}

/// A number of the paper, or none, and what both settings give.
pub fn number(quantity: &str, paper: Option<f64>, found: [Option<Estimate>; 2]) -> Compared {
    let [as_printed, here] = found;
    Compared { quantity: quantity.to_owned(), paper, at_least: false, tolerance: 0.0, as_printed, here }
}

/// A statement of the paper, and whether both settings show it.
pub fn statement(text: &str, [as_printed, here]: [Option<bool>; 2]) -> Statement {
    Statement { text: text.to_owned(), as_printed, here }
}
