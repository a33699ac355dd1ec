//! A preset's text as tables with spans.

use toml::de::DeTable;
use toml_parser::lexer::TokenKind;

use super::diagnostic::{Diagnostic, Diagnostics, PresetError, SourceMap};
use super::value::{Item, Table, Value, own_table};

/// Longest text of one source, bytes. A preset has some kilobytes, a lowered graph some hundreds.
pub const MAX_TEXT: usize = 1 << 20;

/// Most tables and arrays inside one another.
pub const MAX_DEPTH: usize = 32;

/// Nesting that is refused before parsing, so that no recursion runs out of stack.
const MAX_TOKEN_DEPTH: usize = 512;

/// Syntax errors of one source that are told; the rest is counted.
const MAX_ERRORS: usize = 20;

/// A preset as text: tables with spans, not yet typed.
#[derive(Clone, Debug)]
pub struct Document {
    /// Name of the outermost source.
    pub name: String,
    /// The tables; every span is a position in `sources`.
    pub root: Table,
    /// Where it was read from.
    pub sources: SourceMap,
}

impl Document {
    /// Parse one text, telling all its syntax errors.
    ///
    /// An `include` key stays as it is: [`Document::load`] reads what it names.
    pub fn parse(name: &str, text: &str) -> Result<Self, PresetError> {
        Self::parse_bytes(name, text.as_bytes())
    }

    /// Parse one text that may not be UTF-8.
    pub fn parse_bytes(name: &str, bytes: &[u8]) -> Result<Self, PresetError> {
        let mut sources = SourceMap::default();
        let mut diagnostics = Diagnostics::new();
        let root = parse_source(name, bytes, &mut sources, &mut diagnostics);
        diagnostics.finish(&sources)?;
        Ok(Self { name: name.into(), root, sources })
    }
}

/// Add a source and parse it. The table holds what could be read.
pub(super) fn parse_source(
    name: &str,
    bytes: &[u8],
    sources: &mut SourceMap,
    diagnostics: &mut Diagnostics,
) -> Table {
    if bytes.len() > MAX_TEXT {
        let base = sources.add(name, "");
        let message = format!("the text has {} bytes; a preset has at most {MAX_TEXT}", bytes.len());
        let help = "is it a preset? images and tables of values belong into files of their own";
        diagnostics.push(Diagnostic::error("too-long", message).at(base..base, "").help(help));
        return Table::new();
    }
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => {
            let at = error.valid_up_to();
            // What can be read is kept, so that the place has a line and a column.
            let base = sources.add(name, String::from_utf8_lossy(bytes));
            let message = format!("the text is not UTF-8: byte 0x{:02x} at offset {at}", bytes[at]);
            let end = base + at + char::REPLACEMENT_CHARACTER.len_utf8();
            diagnostics.push(
                Diagnostic::error("not-utf8", message)
                    .at(base + at..end, "")
                    .help("save the file as UTF-8 text"),
            );
            return Table::new();
        }
    };
    let base = sources.add(name, text);
    if let Some(at) = too_deep(text) {
        diagnostics.push(depth_error(base + at));
        return Table::new();
    }
    let (root, mut errors) = DeTable::parse_recoverable(text);
    errors.sort_by_key(|e| e.span().map_or(0, |s| s.start));
    let more = errors.len().saturating_sub(MAX_ERRORS);
    diagnostics.extend(errors.iter().take(MAX_ERRORS).map(|e| syntax_error(e, text, base)));
    if more > 0 {
        let message = format!("{more} more syntax errors");
        diagnostics.push(Diagnostic::error("syntax", message).at(base..base, ""));
    }
    let root = own_table(root.into_inner(), base);
    if let Some(at) = deeper_than(&root, MAX_DEPTH) {
        diagnostics.push(depth_error(at));
        return Table::new();
    }
    root
}

fn depth_error(at: usize) -> Diagnostic {
    let message = format!("tables are nested more than {MAX_DEPTH} deep");
    Diagnostic::error("too-deep", message).at(at..at, "").help("no key of a preset lies so deep")
}

/// The parser's error, with what the author most likely meant for the mistakes that are made most.
pub(super) fn syntax_error(error: &toml::de::Error, text: &str, base: usize) -> Diagnostic {
    let span = error.span().unwrap_or(0..0);
    let span = span.start.min(text.len())..span.end.min(text.len());
    let there = text.get(span.clone()).unwrap_or("");
    let at = base + span.start..base + span.end;
    let message = error.message().replace('\n', " ");
    let say = |message: &str| Diagnostic::error("syntax", message).at(at.clone(), "");
    if message.contains("values must be quoted") {
        return if there.is_empty() {
            say("a value is missing").help("write key = value")
        } else {
            say("text without quotes").help(format!("write \"{}\"", there.escape_default()))
        };
    }
    if message.contains("duplicate key") {
        return say(&message).help("a key may be set once; remove one of the two");
    }
    say(&message)
}

/// Position of the first token that nests deeper than [`MAX_TOKEN_DEPTH`]; an upper bound on the parser's nesting.
fn too_deep(text: &str) -> Option<usize> {
    // Dots and brackets of the current header, which hold for all its lines.
    let mut header = 0;
    // Per open bracket, its kind and the dots of the key it stands behind.
    let mut open: Vec<(TokenKind, usize)> = Vec::new();
    let mut outer = 0;
    let mut dots = 0;
    let mut deepest_of_line = 0;
    let mut line_is_header = false;
    let mut line_is_empty = true;
    for token in toml_parser::Source::new(text).lex() {
        match token.kind() {
            TokenKind::Dot => dots += 1,
            TokenKind::Comma => dots = 0,
            kind @ (TokenKind::LeftSquareBracket | TokenKind::LeftCurlyBracket) => {
                if line_is_empty && open.is_empty() {
                    line_is_header = kind == TokenKind::LeftSquareBracket;
                    header = 0;
                }
                open.push((kind, dots));
                outer += 1 + dots;
                dots = 0;
            }
            kind @ (TokenKind::RightSquareBracket | TokenKind::RightCurlyBracket) => {
                let opening = if kind == TokenKind::RightSquareBracket {
                    TokenKind::LeftSquareBracket
                } else {
                    TokenKind::LeftCurlyBracket
                };
                if let Some((_, before)) = open.pop_if(|(kind, _)| *kind == opening) {
                    outer -= 1 + before;
                    dots = before;
                }
            }
            TokenKind::Newline if open.is_empty() => {
                if line_is_header {
                    header = deepest_of_line;
                }
                (dots, deepest_of_line, line_is_header, line_is_empty) = (0, 0, false, true);
                continue;
            }
            _ => {}
        }
        line_is_empty &= matches!(token.kind(), TokenKind::Whitespace | TokenKind::Comment);
        let depth = header + outer + dots;
        deepest_of_line = deepest_of_line.max(depth);
        if depth > MAX_TOKEN_DEPTH {
            return Some(token.span().start());
        }
    }
    None
}

/// Position of the first value below `levels` levels.
fn deeper_than(table: &Table, levels: usize) -> Option<usize> {
    fn inside(value: &Value, levels: usize) -> Option<usize> {
        match value.get_ref() {
            Item::Table(_) | Item::Array(_) if levels == 0 => Some(value.span().start),
            Item::Table(table) => deeper_than(table, levels - 1),
            Item::Array(items) => items.iter().find_map(|v| inside(v, levels - 1)),
            _ => None,
        }
    }
    table.values().find_map(|v| inside(v, levels))
}
