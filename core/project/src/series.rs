//! Pictures of one ground at different times.

pub use time::Date;

use crate::{Extra, Layer, Project};

/// A layer's place in a series.
#[derive(Clone, Debug, PartialEq)]
pub struct Dated {
    /// What layers of one series have in common; 1 to 1000 bytes.
    pub series: String,
    /// The day that the layer shows.
    pub date: Date,
    /// Unknown fields of the file.
    pub extra: Extra,
}

/// A day as `2015-09-26`: years 0 to 9999.
pub fn parse_date(text: &str) -> Option<Date> {
    let mut parts = text.split('-');
    let mut next = |digits: usize| {
        let part = parts.next()?;
        let is_plain = part.len() == digits && part.bytes().all(|b| b.is_ascii_digit());
        is_plain.then(|| part.parse::<u16>().ok())?
    };
    let (year, month, day) = (next(4)?, next(2)?, next(2)?);
    if parts.next().is_some() {
        return None;
    }
    let month = time::Month::try_from(u8::try_from(month).ok()?).ok()?;
    Date::from_calendar_date(year.into(), month, u8::try_from(day).ok()?).ok()
}

impl Project {
    /// All days of layers that are shown, each once, the first first.
    pub fn dates(&self) -> Vec<Date> {
        let shown = self.layers.iter().filter(|layer| layer.visible);
        let mut dates: Vec<Date> = shown
            .filter_map(|layer| Some(layer.dated.as_ref()?.date))
            .collect();
        dates.sort();
        dates.dedup();
        dates
    }
}

impl Layer {
    /// Whether another layer of its series is shown in its stead: of the visible ones `among` all layers,
    /// that is the latest at the `shown` day, or of all where `None` is; the upper one of several of a day.
    /// Before its first day a series shows nothing.
    pub fn is_superseded(&self, among: &[Self], shown: Option<Date>) -> bool {
        let Some(own) = &self.dated else {
            return false;
        };
        let by_now = |date: Date| shown.is_none_or(|shown| date <= shown);
        let of_series = among.iter().filter(|other| {
            let dated = other.dated.as_ref();
            other.visible && dated.is_some_and(|d| d.series == own.series && by_now(d.date))
        });
        let latest = of_series.max_by_key(|other| other.dated.as_ref().map(|d| d.date));
        latest.is_none_or(|latest| latest.id != self.id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LayerId, LayerKind, SlopeLayer};

    fn layer(id: &str, series: &str, date: &str) -> Layer {
        let kind = LayerKind::Slope(SlopeLayer::default());
        let mut layer = Layer::new(LayerId::from(id), id, kind);
        layer.dated = Some(Dated {
            series: series.to_owned(),
            date: parse_date(date).unwrap(),
            extra: Extra::new(),
        });
        layer
    }

    fn shown(project: &Project) -> Vec<&str> {
        let (all, date) = (&project.layers, project.date);
        let current = all.iter().filter(|l| !l.is_superseded(all, date));
        current.map(|l| l.id.0.as_str()).collect()
    }

    #[test]
    fn each_series_shows_its_latest_picture_at_the_shown_date() {
        let mut project = Project {
            layers: vec![
                layer("a-2015", "a", "2015-09-26"),
                layer("a-2010", "a", "2010-06-29"),
                layer("b-2012", "b", "2012-02-29"),
                layer("b-again", "b", "2012-02-29"),
                Layer::new(
                    LayerId::from("always"),
                    "always",
                    LayerKind::Slope(SlopeLayer::default()),
                ),
            ],
            ..Project::default()
        };
        assert_eq!(shown(&project), ["a-2015", "b-again", "always"]);
        project.date = parse_date("2012-02-28");
        assert_eq!(shown(&project), ["a-2010", "always"]);
        project.date = parse_date("2009-01-01");
        assert_eq!(shown(&project), ["always"]);
        project.date = None;
        project.layers[0].visible = false;
        assert_eq!(shown(&project), ["a-2010", "b-again", "always"]);
        let dates: Vec<String> = project.dates().iter().map(Date::to_string).collect();
        assert_eq!(dates, ["2010-06-29", "2012-02-29"]);
    }

    #[test]
    fn only_days_that_there_are_are_dates() {
        for text in ["2015-09-26", "0000-01-01", "9999-12-31", "2012-02-29"] {
            assert_eq!(
                parse_date(text).map(|d| d.to_string()).as_deref(),
                Some(text)
            );
        }
        for text in [
            "",
            "2015",
            "2015-9-26",
            "2013-02-29",
            "2015-13-01",
            "2015-00-10",
            "2015-09-26-1",
            "+015-09-26",
        ] {
            assert_eq!(parse_date(text), None, "{text}");
        }
    }
}
