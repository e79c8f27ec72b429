//! Places by name: the populated places of Natural Earth 1:50m, which are in the public domain.

use std::sync::LazyLock;

use relievo_planet::MapPoint;

/// A town or city of the Earth.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Its name as it is written there, in Latin letters.
    pub name: &'static str,
    /// Three letters of its country.
    pub country: &'static str,
    /// Where it is.
    pub at: MapPoint,
    /// People in and around it.
    pub people: u64,
}

/// What is searched: names in lower case and without marks on letters.
static PLACES: LazyLock<Vec<(String, Place)>> = LazyLock::new(|| {
    include_str!("../data/places.tsv")
        .lines()
        .filter_map(|line| {
            let mut fields = line.split('\t');
            let name = fields.next()?;
            let country = fields.next()?;
            let lon: f64 = fields.next()?.parse().ok()?;
            let lat: f64 = fields.next()?.parse().ok()?;
            let people = fields.next()?.parse().ok()?;
            let place = Place {
                name,
                country,
                at: MapPoint::from_degrees(lon, lat),
                people,
            };
            Some((plain(name), place))
        })
        .collect()
});

/// Places whose name has the words of `text` in it, at most `count`: names that are the text first,
/// then those that begin with it, then those with a word that begins with it, then the rest; larger
/// ones first. Case and marks on letters do not matter; a country's three letters may follow a comma
/// (`Paris, FRA`). Nothing for a text without letters.
pub fn find(text: &str, count: usize) -> Vec<&'static Place> {
    let (name, country) = text.split_once(',').unwrap_or((text, ""));
    let (name, country) = (plain(name), country.trim().to_uppercase());
    if name.is_empty() {
        return Vec::new();
    }
    let rank = |found: &str| {
        if found == name {
            Some(0)
        } else if found.starts_with(&name) {
            Some(1)
        } else if found
            .match_indices(&name)
            .any(|(at, _)| found[..at].ends_with([' ', '-', '\'']))
        {
            Some(2)
        } else if name.len() > 2 && found.contains(&name) {
            Some(3)
        } else {
            None
        }
    };
    let mut found: Vec<(u8, &Place)> = PLACES
        .iter()
        .filter(|(_, place)| place.country.starts_with(&country))
        .filter_map(|(plain, place)| Some((rank(plain)?, place)))
        .collect();
    // The table is in order of people already.
    found.sort_by_key(|(rank, _)| *rank);
    found.truncate(count);
    found.into_iter().map(|(_, place)| place).collect()
}

/// Lower case, letters without their marks, single spaces.
fn plain(text: &str) -> String {
    let mut plain = String::new();
    for c in text.trim().chars().flat_map(char::to_lowercase) {
        match c {
            'à'..='å' | 'ā' | 'ă' | 'ą' => plain.push('a'),
            'æ' => plain.push_str("ae"),
            'ç' | 'ć' | 'č' => plain.push('c'),
            'đ' | 'ð' | 'ď' => plain.push('d'),
            'è'..='ë' | 'ē' | 'ė' | 'ę' | 'ě' => plain.push('e'),
            'ğ' | 'ģ' | 'ġ' => plain.push('g'),
            'ħ' => plain.push('h'),
            'ì'..='ï' | 'ī' | 'ı' => plain.push('i'),
            'ķ' => plain.push('k'),
            'ł' | 'ļ' => plain.push('l'),
            'ñ' | 'ń' | 'ň' | 'ņ' => plain.push('n'),
            'ò'..='ö' | 'ø' | 'ō' | 'ő' => plain.push('o'),
            'œ' => plain.push_str("oe"),
            'ř' => plain.push('r'),
            'ś' | 'š' | 'ş' | 'ș' => plain.push('s'),
            'ß' => plain.push_str("ss"),
            'ţ' | 'ț' | 'ť' => plain.push('t'),
            'ù'..='ü' | 'ū' | 'ű' | 'ů' => plain.push('u'),
            'ý' | 'ÿ' => plain.push('y'),
            'ź' | 'ż' | 'ž' => plain.push('z'),
            // Marks that stand behind their letter, as some systems type them.
            '\u{300}'..='\u{36f}' => {}
            '\u{2018}' | '\u{2019}' | '`' => plain.push('\''),
            c if c.is_whitespace() => {
                if !plain.ends_with(' ') {
                    plain.push(' ');
                }
            }
            c => plain.push(c),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(text: &str) -> Option<(&'static str, &'static str)> {
        find(text, 1).first().map(|p| (p.name, p.country))
    }

    #[test]
    fn a_name_is_found_without_its_marks_and_by_its_beginning() {
        for text in ["Zürich", "zurich", "ZÜRI", "  zurich ", "zu\u{308}rich"] {
            assert_eq!(first(text), Some(("Zürich", "CHE")), "{text}");
        }
        assert_eq!(first("são pau"), first("sao paulo"));
    }

    #[test]
    fn larger_places_and_whole_names_come_first() {
        assert_eq!(first("london").unwrap().1, "GBR");
        let found = find("san", 5);
        assert!(
            found.windows(2).all(|p| p[0].people >= p[1].people),
            "{found:?}"
        );
        assert!(found.len() == 5 && find("york", 3).iter().any(|p| p.name == "New York"));
    }

    #[test]
    fn a_country_narrows_and_nonsense_finds_nothing() {
        assert!(find("san, chl", 9).iter().all(|p| p.country == "CHL"));
        for text in ["", " ", ",", "qqqq", "\0", "🗺"] {
            assert_eq!(find(text, 9), Vec::<&Place>::new());
        }
    }

    #[test]
    fn every_line_of_the_table_is_a_place() {
        let lines = include_str!("../data/places.tsv").lines().count();
        assert_eq!(PLACES.len(), lines - 1);
        assert!(
            PLACES
                .iter()
                .all(|(_, p)| p.name.len() < 80 && p.country.len() == 3)
        );
        let zurich = find("zürich", 1)[0].at.to_degrees();
        assert!((zurich.0 - 8.55).abs() < 0.05 && (zurich.1 - 47.38).abs() < 0.05);
    }
}
