//! Tables as text: CSV (RFC 4180), or with tabs; cells that need quotes have them.

use csv::{ReaderBuilder, Trim, WriterBuilder};
use std::io::{self, Write};

/// A header and rows as CSV.
pub fn csv(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    delimited(b',', header, rows)
}

/// A header and rows, their cells apart by `delimiter`.
pub fn delimited(delimiter: u8, header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let mut text = Vec::new();
    // memory takes every row
    let _ = Writer::begin(&mut text, delimiter, header).and_then(|mut writer| {
        rows.into_iter().try_for_each(|row| writer.row(row))?;
        writer.end()
    });
    String::from_utf8_lossy(&text).into_owned()
}

/// A table that is written row by row.
pub struct Writer<W: Write>(csv::Writer<W>);

impl<W: Write> Writer<W> {
    /// Its header, cells apart by `delimiter`.
    ///
    /// # Errors
    ///
    /// What the file says, here and below.
    pub fn begin(file: W, delimiter: u8, header: &[&str]) -> io::Result<Self> {
        let mut writer = Writer(WriterBuilder::new().delimiter(delimiter).flexible(true).from_writer(file));
        writer.row(header.iter().map(|&name| name.to_owned()).collect())?;
        Ok(writer)
    }

    /// A row.
    pub fn row(&mut self, cells: Vec<String>) -> io::Result<()> {
        Ok(self.0.write_record(cells.into_iter().map(text_of))?)
    }

    /// Nothing is left to be written.
    pub fn end(mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// A cell that a spreadsheet takes for text too: what it would take for a formula, also by a sign of double width, gets an apostrophe
/// before it. Numbers stay.
fn text_of(cell: String) -> String {
    const SIGNS: [char; 11] = ['=', '+', '-', '@', '\t', '\r', '\n', '＝', '＋', '－', '＠'];
    let formula = cell.starts_with(SIGNS) && cell.parse::<f64>().is_err();
    if formula { format!("'{cell}") } else { cell }
}

/// The cells of a line of CSV, without the blanks around them.
pub fn cells(line: &str) -> Vec<String> {
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .trim(Trim::All)
        .buffer_capacity(line.len() + 1)
        .from_reader(line.as_bytes());
    let row = reader.records().next().and_then(Result::ok).unwrap_or_default();
    row.iter().map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_cell_is_a_formula() {
        let row = ["=1+1", "@SUM(A1)", "-1.5e-3", "+3", "-", "-x", "\n=1", "＝1"].map(str::to_owned).to_vec();
        assert_eq!(csv(&["a"], [row]), "a\n'=1+1,'@SUM(A1),-1.5e-3,+3,'-,'-x,\"'\n=1\",'＝1\n");
    }

    #[test]
    fn cells_with_commas_quotes_and_line_breaks_come_back() {
        let row = ["a, b", "say \"x\"", "plain", ""].map(str::to_owned).to_vec();
        let text = csv(&["one", "two", "three", "four"], [row.clone()]);
        assert_eq!(text, "one,two,three,four\n\"a, b\",\"say \"\"x\"\"\",plain,\n");
        assert_eq!(cells(text.lines().nth(1).unwrap()), row);
        assert_eq!(cells(" 200 ,\"0.5\",,"), ["200", "0.5", "", ""]);
        assert_eq!(delimited(b'\t', &["a", "b"], [vec!["1".into(), "x,y".into()]]), "a\tb\n1\tx,y\n");
        assert!(csv(&["a", "b"], [vec!["x\ny".into(), "1".into()]]).contains("\"x\ny\",1\n"));
    }
}
