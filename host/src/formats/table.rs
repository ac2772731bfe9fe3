//! Tables as text: CSV (RFC 4180), or with tabs; cells that need quotes have them.

use csv::{ReaderBuilder, Trim, WriterBuilder};

/// A header and rows as CSV.
pub fn csv(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    delimited(b',', header, rows)
}

/// A header and rows, their cells apart by `delimiter`.
pub fn delimited(delimiter: u8, header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let mut writer = WriterBuilder::new().delimiter(delimiter).flexible(true).from_writer(Vec::new());
    let header = header.iter().map(|&name| name.to_owned()).collect();
    for row in std::iter::once(header).chain(rows) {
        // memory takes every row
        let _ = writer.write_record(row.into_iter().map(text_of));
    }
    String::from_utf8_lossy(&writer.into_inner().unwrap_or_default()).into_owned()
}

/// A cell that a spreadsheet takes for text too: what it would take for a formula gets an apostrophe before it. Numbers stay.
fn text_of(cell: String) -> String {
    let formula = cell.len() > 1 && cell.starts_with(['=', '+', '-', '@', '\t', '\r']);
    if formula && cell.parse::<f64>().is_err() { format!("'{cell}") } else { cell }
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
        let row = ["=1+1", "@SUM(A1)", "-1.5e-3", "+3", "-", "-x"].map(str::to_owned).to_vec();
        assert_eq!(csv(&["a"], [row]), "a\n'=1+1,'@SUM(A1),-1.5e-3,+3,-,'-x\n");
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
