//! How well letters that were typed fit a title.

/// For a letter at the start of a word.
const START: i32 = 12;

/// For a letter right after the one before.
const NEXT: i32 = 8;

/// For any letter that is found.
const FOUND: i32 = 2;

/// How well `typed` fits `title`: larger is better; `None` where its letters are not all there in
/// their order. Case and spaces do not count; nothing fits everything.
pub(super) fn score(typed: &str, title: &str) -> Option<i32> {
    let title: Vec<char> = title.chars().flat_map(char::to_lowercase).collect();
    let typed: Vec<char> = typed
        .chars()
        .filter(|c| !c.is_whitespace())
        .flat_map(char::to_lowercase)
        .collect();
    // best[j]: best score of the letters so far with the last of them at j of the title.
    let mut best: Vec<Option<i32>> = Vec::new();
    for (i, letter) in typed.iter().enumerate() {
        let mut next = vec![None; title.len()];
        let mut before: Option<i32> = (i == 0).then_some(0);
        for (j, there) in title.iter().enumerate() {
            if there == letter {
                let starts = j == 0 || !title[j - 1].is_alphanumeric();
                let gained = FOUND + if starts { START } else { 0 };
                let beside = j
                    .checked_sub(1)
                    .and_then(|j| best.get(j).copied().flatten())
                    .map(|score| score + NEXT);
                next[j] = before.max(beside).map(|score| score + gained);
            }
            if i > 0 {
                before = before.max(best[j]);
            }
        }
        best = next;
    }
    let found = if typed.is_empty() {
        Some(0)
    } else {
        best.into_iter().flatten().max()
    };
    // Of titles that fit alike the shorter one.
    found.map(|score| score * 256 - title.len().min(255) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order<'a>(typed: &str, titles: &[&'a str]) -> Vec<&'a str> {
        let mut scored: Vec<(i32, &str)> = titles
            .iter()
            .filter_map(|t| Some((score(typed, t)?, *t)))
            .collect();
        scored.sort_by_key(|(s, _)| core::cmp::Reverse(*s));
        scored.into_iter().map(|(_, t)| t).collect()
    }

    #[test]
    fn starts_of_words_and_runs_of_letters_fit_best() {
        let titles = [
            "Save",
            "Save as…",
            "Save picture…",
            "Usual size",
            "Colours of the system",
        ];
        assert_eq!(
            order("save", &titles),
            ["Save", "Save as…", "Save picture…"]
        );
        assert_eq!(order("sp", &titles)[0], "Save picture…");
        assert_eq!(order("us", &titles)[0], "Usual size");
    }

    #[test]
    fn letters_count_in_their_order_only_and_nothing_fits_all() {
        assert_eq!(score("as", "Save"), None);
        assert_eq!(score("savex", "Save"), None);
        assert!(score("", "Save").is_some() && score("  ", "Save").is_some());
        assert_eq!(score("NORTH up", "North up"), score("northup", "north UP"));
        assert!(score("é", "Été").is_some());
        assert_eq!(score("x", ""), None);
    }
}
