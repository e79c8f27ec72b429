//! The nested lists that Well-Known Text is made of.

/// How deep lists may be nested.
const MAX_DEPTH: usize = 32;

/// `NAME[values and children]`.
#[derive(Debug, Default)]
pub(super) struct Node {
    /// As [`plain`] has it.
    pub(super) name: String,
    /// Quoted texts, numbers and bare words, in order.
    pub(super) values: Vec<String>,
    pub(super) children: Vec<Self>,
}

/// Lower case, letters and digits only: dialects differ in the rest.
pub(super) fn plain(text: &str) -> String {
    text.chars()
        .filter(char::is_ascii_alphanumeric)
        .map(|c| c.to_ascii_lowercase())
        .collect()
}

impl Node {
    /// The list that a text consists of.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let mut rest = text.trim();
        let node = Self::take(&mut rest, 0)?;
        rest.trim().is_empty().then_some(node)
    }

    fn take(rest: &mut &str, depth: usize) -> Option<Self> {
        if depth > MAX_DEPTH {
            return None;
        }
        let name = word(rest)?;
        *rest = rest.trim_start().strip_prefix(['[', '('])?;
        let mut node = Self {
            name: plain(&name),
            ..Self::default()
        };
        loop {
            *rest = rest.trim_start();
            if let Some(quoted) = rest.strip_prefix('"') {
                let (value, after) = quoted.split_once('"')?;
                node.values.push(value.to_owned());
                *rest = after;
            } else {
                let mut ahead = *rest;
                let value = word(&mut ahead)?;
                if ahead.trim_start().starts_with(['[', '(']) {
                    node.children.push(Self::take(rest, depth + 1)?);
                } else {
                    node.values.push(value);
                    *rest = ahead;
                }
            }
            *rest = rest.trim_start();
            if let Some(after) = rest.strip_prefix(',') {
                *rest = after;
            } else {
                *rest = rest.strip_prefix([']', ')'])?;
                return Some(node);
            }
        }
    }

    /// The first list of one of these names, at any depth.
    pub(super) fn find(&self, names: &[&str]) -> Option<&Self> {
        self.children.iter().find_map(|child| {
            if names.contains(&&*child.name) {
                Some(child)
            } else {
                child.find(names)
            }
        })
    }

    /// All lists of a name, at any depth.
    pub(super) fn all(&self, name: &str) -> Vec<&Self> {
        let mut found = Vec::new();
        for child in &self.children {
            if child.name == name {
                found.push(child);
            }
            found.extend(child.all(name));
        }
        found
    }
}

/// A bare word or number.
fn word(rest: &mut &str) -> Option<String> {
    let text = rest.trim_start();
    let end = text
        .find(|c: char| c.is_whitespace() || "[](),\"".contains(c))
        .unwrap_or(text.len());
    let (word, after) = text.split_at(end);
    *rest = after;
    (!word.is_empty()).then(|| word.to_owned())
}
