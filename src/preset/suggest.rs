//! Did you mean …?

/// Edits (insert, delete, replace, swap of neighbours) that turn `a` into `b`: the optimal string alignment
/// distance, on characters, ignoring ASCII case.
pub fn distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().map(|c| c.to_ascii_lowercase()).collect();
    let b: Vec<char> = b.chars().map(|c| c.to_ascii_lowercase()).collect();
    let mut before = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let cost = usize::from(a[i - 1] != b[j - 1]);
            row[j] = (last[j] + 1).min(row[j - 1] + 1).min(last[j - 1] + cost);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

/// The candidate that was most likely meant by `word`: at most one edit per three characters away, or one that
/// `word` begins or that begins `word` (three characters or more). The first of equals.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Nobody mistypes a word this long; and the distance is quadratic.
    if word.chars().count() > 64 {
        return None;
    }
    let prefix = |a: &str, b: &str| {
        let short = a.len().min(b.len());
        short >= 3
            && a.is_char_boundary(short)
            && b.is_char_boundary(short)
            && a[..short].eq_ignore_ascii_case(&b[..short])
    };
    candidates
        .into_iter()
        .filter(|c| *c != word)
        .filter_map(|c| {
            let d = distance(word, c);
            let allowed = (word.chars().count().max(c.chars().count()) / 3).max(1);
            if d <= allowed {
                Some((d, c))
            } else if prefix(word, c) {
                Some((allowed + d, c))
            } else {
                None
            }
        })
        .min_by_key(|(d, _)| *d)
        .map(|(_, c)| c)
}

/// The help line for an unknown `word`: the nearest candidate, else the list of all (at most 12).
pub fn help(word: &str, candidates: &[&str]) -> Option<String> {
    if let Some(near) = nearest(word, candidates.iter().copied()) {
        return Some(format!("did you mean `{near}`?"));
    }
    let shown: Vec<String> = candidates.iter().take(12).map(|c| format!("`{c}`")).collect();
    let more = candidates.len().saturating_sub(shown.len());
    match (shown.is_empty(), more) {
        (true, _) => None,
        (false, 0) => Some(format!("known: {}", shown.join(", "))),
        (false, more) => Some(format!("known: {} and {more} more", shown.join(", "))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_the_textbook_ones() {
        for (a, b, d) in [
            ("", "", 0),
            ("", "abc", 3),
            ("kitten", "sitting", 3),
            ("ca", "ac", 1),
            ("Size", "size", 0),
            ("ca", "abc", 3),
        ] {
            assert_eq!(distance(a, b), d, "{a} {b}");
            assert_eq!(distance(b, a), d, "{b} {a}");
        }
    }

    #[test]
    fn typos_find_their_word_and_strangers_do_not() {
        let words = ["size", "seed", "overlap", "keel", "worley", "gradient_map"];
        assert_eq!(nearest("sise", words), Some("size"));
        assert_eq!(nearest("ovrelap", words), Some("overlap"));
        assert_eq!(nearest("gradient", words), Some("gradient_map"));
        assert_eq!(nearest("iridescence", words), None);
        assert_eq!(
            nearest("size", words),
            Some("seed").filter(|_| false),
            "the word itself is no suggestion"
        );
        assert_eq!(nearest(&"x".repeat(100_000), words), None);
    }

    #[test]
    fn help_lists_when_nothing_is_near() {
        assert_eq!(help("qqqq", &["a", "b"]).as_deref(), Some("known: `a`, `b`"));
        assert_eq!(help("qqqq", &[]), None);
        let many: Vec<String> = (0..20).map(|i| format!("key{i}")).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        assert!(help("zzzzzzz", &many).is_some_and(|h| h.ends_with("`key11` and 8 more")));
    }
}
