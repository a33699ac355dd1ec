//! Values with their places.
//!
//! The parser's own tree borrows the text and cannot be made to outlive it; this one owns what it holds, and lends
//! itself to serde through [`lend`].

use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

/// A value with its place.
pub type Value = Spanned<Item>;

/// A table of values with their places; its order is the text's.
pub type Table = toml::map::Map<Spanned<String>, Value>;

/// A number as it was written, without underscores.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Number(String);

impl Number {
    /// The number's text, such as `0.25`, `0xff` or `inf`.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// What a key can hold.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// `"…"`.
    String(String),
    /// `12`.
    Integer(Number),
    /// `1.5`.
    Float(Number),
    /// `true` or `false`.
    Boolean(bool),
    /// A date or a time; no preset needs one.
    Datetime(toml::value::Datetime),
    /// `[…]`, or what `[[…]]` gathers.
    Array(Vec<Value>),
    /// `[…]`, `{…}`, or what dotted keys imply.
    Table(Table),
}

impl Item {
    /// The text of a string.
    pub fn as_str(&self) -> Option<&str> {
        if let Self::String(s) = self { Some(s) } else { None }
    }

    /// The value of a number; `None` for an integer that f64 or i128 cannot hold, too.
    pub fn as_f64(&self) -> Option<f64> {
        match self {
            Self::Float(n) => n.0.parse().ok(),
            Self::Integer(n) => {
                let radix = |digits: &str, radix| i128::from_str_radix(digits, radix).ok();
                let value = match n.0.get(..2) {
                    Some("0x") => radix(&n.0[2..], 16),
                    Some("0o") => radix(&n.0[2..], 8),
                    Some("0b") => radix(&n.0[2..], 2),
                    _ => radix(&n.0, 10),
                };
                value.map(|v| v as f64)
            }
            _ => None,
        }
    }

    /// The value of a boolean.
    pub fn as_bool(&self) -> Option<bool> {
        if let Self::Boolean(b) = self { Some(*b) } else { None }
    }

    /// The items of an array.
    pub fn as_array(&self) -> Option<&[Value]> {
        if let Self::Array(items) = self { Some(items) } else { None }
    }

    /// The table.
    pub fn as_table(&self) -> Option<&Table> {
        if let Self::Table(table) = self { Some(table) } else { None }
    }

    /// The table.
    pub fn as_table_mut(&mut self) -> Option<&mut Table> {
        if let Self::Table(table) = self { Some(table) } else { None }
    }

    /// Its kind in messages, such as `a number`.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::String(_) => "a string",
            Self::Integer(_) | Self::Float(_) => "a number",
            Self::Boolean(_) => "true or false",
            Self::Datetime(_) => "a date",
            Self::Array(_) => "a list",
            Self::Table(_) => "a table",
        }
    }
}

/// The value as the parser would have made it, borrowing from `value`; spans are kept.
pub fn lend(value: &Value) -> Spanned<DeValue<'_>> {
    let lent = match value.get_ref() {
        Item::String(s) => DeValue::String(s.as_str().into()),
        Item::Integer(n) | Item::Float(n) => match DeValue::parse(&n.0) {
            Ok(number) => number.into_inner(),
            // Only the parser makes numbers, so it can read them.
            Err(_) => DeValue::String(n.0.as_str().into()),
        },
        Item::Boolean(b) => DeValue::Boolean(*b),
        Item::Datetime(d) => DeValue::Datetime(*d),
        Item::Array(items) => DeValue::Array(items.iter().map(lend).collect()),
        Item::Table(table) => DeValue::Table(lend_table(table)),
    };
    Spanned::new(value.span(), lent)
}

fn lend_table(table: &Table) -> DeTable<'_> {
    table.iter().map(|(k, v)| (Spanned::new(k.span(), k.get_ref().as_str().into()), lend(v))).collect()
}

/// A deserialiser over the value, whose errors carry spans.
pub fn deserializer(value: &Value) -> ValueDeserializer<'_> {
    lend(value).into()
}

/// Own what the parser read, every span moved by `base`.
pub(super) fn own(value: Spanned<DeValue<'_>>, base: usize) -> Value {
    let span = value.span();
    let item = match value.into_inner() {
        DeValue::String(s) => Item::String(s.into_owned()),
        DeValue::Integer(n) => Item::Integer(Number(n.to_string())),
        DeValue::Float(n) => Item::Float(Number(n.to_string())),
        DeValue::Boolean(b) => Item::Boolean(b),
        DeValue::Datetime(d) => Item::Datetime(d),
        DeValue::Array(items) => Item::Array(items.into_iter().map(|v| own(v, base)).collect()),
        DeValue::Table(table) => Item::Table(own_table(table, base)),
    };
    Spanned::new(span.start + base..span.end + base, item)
}

/// Own a table, every span moved by `base`.
pub(super) fn own_table(table: DeTable<'_>, base: usize) -> Table {
    table
        .into_iter()
        .map(|(k, v)| {
            let span = k.span();
            (Spanned::new(span.start + base..span.end + base, k.into_inner().into_owned()), own(v, base))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Value {
        own(DeValue::parse(text).expect("the test's TOML"), 0)
    }

    #[test]
    fn numbers_keep_their_value() {
        for (text, number) in [
            ("1_000", 1000.0),
            ("-3", -3.0),
            ("+7", 7.0),
            ("0xff", 255.0),
            ("0o17", 15.0),
            ("0b101", 5.0),
            ("0.1", 0.1),
            ("1e3", 1000.0),
            ("-inf", f64::NEG_INFINITY),
            ("18446744073709551615", 18446744073709551615.0),
        ] {
            let value = value(text);
            assert_eq!(value.get_ref().as_f64(), Some(number), "{text}");
            let f: f64 = serde::Deserialize::deserialize(deserializer(&value)).expect(text);
            assert_eq!(f, number, "{text}");
        }
    }

    #[test]
    fn lending_gives_what_the_parser_gave() {
        let text = r#"{ a = [1, 2.5, "x", true, 1979-05-27], b = { c = 0x10, d = 'q"' }, e = nan }"#;
        let parsed = DeValue::parse(text).expect("the test's TOML");
        assert_eq!(format!("{parsed:?}"), format!("{:?}", lend(&value(text))));
    }
}
