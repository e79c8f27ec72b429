//! Text for people.

/// What others say, in one line: some decoders break theirs.
pub(crate) fn one_line(text: impl core::fmt::Display) -> String {
    let text = text.to_string();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    #[test]
    fn lines_become_one() {
        assert_eq!(super::one_line("a\n b\r\n\n"), "a b");
    }
}
