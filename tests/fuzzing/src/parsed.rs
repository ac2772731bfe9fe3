//! What third-party parsers find in a text that the host wrote: its parts, one string each, in order.
//!
//! No parser here is one that the host uses. Options of sbatch and cells of CSV are read by code of our own, by Slurm's manual and RFC 4180.

use brush_parser::word::{WordPiece, parse};
use brush_parser::{ParserOptions, Token};
use saphyr_parser::{Event, Parser};
use scraper::{Html, Node};
use unicode_bidi::{BidiClass, bidi_class};

/// The parts of a text.
pub type Parts = Vec<String>;

/// Compares the parts of a text with the placeholder `mark` and of the same text with another word in its place, written in any of `forms`.
///
/// # Errors
///
/// The first part that differs in more than the word.
pub fn same_but_for(mark: &str, forms: &[&str], with_mark: &Parts, other: &Parts) -> Result<(), String> {
    if with_mark.len() != other.len() {
        return Err(format!("{} parts, not {}", other.len(), with_mark.len()));
    }
    let differs = |(marked, part): &(&String, &String)| {
        marked != part && !forms.iter().any(|form| marked.replace(mark, form) == **part)
    };
    match with_mark.iter().zip(other).find(differs) {
        Some((marked, part)) => Err(format!("{part:?} for {marked:?}")),
        None => Ok(()),
    }
}

/// A page: the depth and name of each element, the names of its attributes, addresses, and every text.
pub fn html(page: &str) -> Parts {
    let parsed = Html::parse_document(page);
    let descendants = parsed.tree.root().descendants();
    let part = descendants.map(|node| match node.value() {
        Node::Element(element) => {
            let mut part = format!("{} <{}", node.ancestors().count(), element.name());
            element.attrs().for_each(|(name, value)| part += &attribute(name, value));
            part
        }
        Node::Text(text) => format!("text {}", &text[..]),
        other => format!("{other:?}"),
    });
    part.collect()
}

/// A picture, as [`html()`]; an error if it is no XML.
pub fn svg(picture: &str) -> Result<Parts, String> {
    let parsed = roxmltree::Document::parse(picture).map_err(|error| error.to_string())?;
    let part = |node: roxmltree::Node| match node.is_element() {
        true => {
            let mut part = format!("{} <{}", node.ancestors().count(), node.tag_name().name());
            node.attributes().for_each(|one| part += &attribute(one.name(), one.value()));
            part
        }
        false => format!("{:?} {}", node.node_type(), node.text().unwrap_or_default()),
    };
    Ok(parsed.root().descendants().map(part).collect())
}

/// Coordinates and sizes depend on the lengths of texts, so only addresses and styles are compared by value.
fn attribute(name: &str, value: &str) -> String {
    match name.starts_with("on") || matches!(name, "href" | "src" | "style" | "fill" | "stroke") {
        true => format!(" {name}={value}"),
        false => format!(" {name}"),
    }
}

/// YAML: every event, scalars with their values.
pub fn yaml(text: &str) -> Result<Parts, String> {
    let part = |event: Result<(Event, _), saphyr_parser::ScanError>| match event {
        Ok((Event::Scalar(value, ..), _)) => Ok(format!("scalar {value}")),
        Ok((other, _)) => Ok(format!("{other:?}")),
        Err(error) => Err(error.to_string()),
    };
    Parser::new_from_str(text).map(part).collect()
}

/// A shell script: operators and words; of a word that is quoted whole, what it stands for.
pub fn shell(script: &str) -> Result<Parts, String> {
    let options = ParserOptions::default();
    let literal = |word: &str| -> Option<String> {
        let pieces = parse(word, &options).ok()?;
        let one = |piece: brush_parser::word::WordPieceWithSource| match piece.piece {
            WordPiece::SingleQuotedText(text) => Some(text),
            WordPiece::EscapeSequence(text) => Some(text.trim_start_matches('\\').to_owned()),
            _ => None,
        };
        pieces.into_iter().map(one).collect()
    };
    let part = |token: Token| match token {
        Token::Operator(operator, _) => format!("operator {operator:?}"),
        Token::Word(word, _) => match literal(&word) {
            Some(text) => format!("quoted {text}"),
            None => format!("word {word}"),
        },
    };
    let tokens = brush_parser::uncached_tokenize_str(script, &Default::default());
    Ok(tokens.map_err(|error| error.to_string())?.into_iter().map(part).collect())
}

/// What sbatch reads of a script: the words of each line of options, up to the first line that is no comment.
pub fn sbatch(script: &str) -> Parts {
    let comments = script.split('\n').take_while(|line| line.starts_with('#'));
    let mut parts = Vec::new();
    for line in comments {
        let Some(options) = line.strip_prefix("#SBATCH") else { continue };
        if ["hetjob", "packjob"].iter().any(|separator| line.contains(separator)) {
            parts.push("component".into());
        }
        let (mut word, mut quote, mut escaped) = (None::<String>, None, false);
        for c in options.chars() {
            match c {
                _ if escaped => {
                    word.get_or_insert_default().push(c);
                    escaped = false;
                }
                '\\' => escaped = true,
                '#' if quote.is_none() && word.is_none() => break,
                '"' | '\'' if quote == Some(c) => quote = None,
                '"' | '\'' if quote.is_none() => {
                    word.get_or_insert_default();
                    quote = Some(c);
                }
                ' ' | '\t' | '\r' | '\u{b}' | '\u{c}' if quote.is_none() => parts.extend(word.take()),
                _ => word.get_or_insert_default().push(c),
            }
        }
        parts.extend(word);
        parts.push("line".into());
    }
    parts
}

/// The cells of a table by RFC 4180, rows one after the other; a row ends with `row`.
pub fn csv(text: &str) -> Parts {
    let (mut parts, mut cell, mut quoted) = (Vec::new(), String::new(), false);
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '"' if quoted && rest.peek() == Some(&'"') => cell.extend(rest.next()),
            '"' if quoted => quoted = false,
            '"' if cell.is_empty() => quoted = true,
            ',' if !quoted => parts.push(std::mem::take(&mut cell)),
            '\n' if !quoted => parts.extend([std::mem::take(&mut cell), "row".into()]),
            _ => cell.push(c),
        }
    }
    parts
}

/// Whether a spreadsheet computes a cell: it begins with a sign, also one of double width, and is no number.
pub fn is_formula(cell: &str) -> bool {
    let signs = ['=', '+', '-', '@', '\t', '\r', '\n', '\u{ff1d}', '\u{ff0b}', '\u{ff0d}', '\u{ff20}'];
    cell.starts_with(signs) && cell.parse::<f64>().is_err()
}

/// What a terminal does with a text other than display it, if anything.
pub fn terminal(text: &str) -> Option<String> {
    let mut found = Found::default();
    vte::Parser::new().advance(&mut found, text.as_bytes());
    found.0
}

#[derive(Default)]
struct Found(Option<String>);

impl vte::Perform for Found {
    fn print(&mut self, c: char) {
        use BidiClass::{B, BN, FSI, LRE, LRI, LRO, PDF, PDI, RLE, RLI, RLO};
        if matches!(bidi_class(c), B | BN | FSI | LRE | LRI | LRO | PDF | PDI | RLE | RLI | RLO) {
            self.0 = Some(format!("prints {c:?}"));
        }
    }

    fn execute(&mut self, byte: u8) {
        if !matches!(byte, b'\n' | b'\t') {
            self.0 = Some(format!("executes {byte:#04x}"));
        }
    }

    fn hook(&mut self, _: &vte::Params, _: &[u8], _: bool, action: char) {
        self.0 = Some(format!("begins a device control string {action:?}"));
    }

    fn osc_dispatch(&mut self, _: &[&[u8]], _: bool) {
        self.0 = Some("obeys an operating system command".into());
    }

    fn csi_dispatch(&mut self, _: &vte::Params, _: &[u8], _: bool, action: char) {
        self.0 = Some(format!("obeys a control sequence {action:?}"));
    }

    fn esc_dispatch(&mut self, _: &[u8], _: bool, byte: u8) {
        self.0 = Some(format!("obeys an escape sequence {byte:#04x}"));
    }
}
