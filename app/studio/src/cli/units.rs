//! Values of arguments: places, sizes, bounds.

/// `LON,LAT` in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// −360 to 360, east.
    pub(crate) lon_deg: f64,
    /// −90 to 90.
    pub(crate) lat_deg: f64,
}

/// Reads `LON,LAT`.
pub(crate) fn place(text: &str) -> Result<Place, String> {
    let [lon_deg, lat_deg] = numbers(text, "LON,LAT in degrees")?;
    if !(-360.0..=360.0).contains(&lon_deg) {
        return Err(format!(
            "expected a longitude of -360 to 360 degrees, found {lon_deg}"
        ));
    }
    if !(-90.0..=90.0).contains(&lat_deg) {
        return Err(format!(
            "expected a latitude of -90 to 90 degrees, found {lat_deg}"
        ));
    }
    Ok(Place { lon_deg, lat_deg })
}

/// Places joined to a line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Line(pub(crate) Vec<Place>);

/// Reads `LON,LAT;LON,LAT...`.
pub(crate) fn line(text: &str) -> Result<Line, String> {
    let places: Result<Vec<Place>, String> = text.split(';').map(place).collect();
    match places?.as_slice() {
        [] | [_] => Err(format!(
            "expected LON,LAT;LON,LAT... of at least 2 places, found {text:?}"
        )),
        places => Ok(Line(places.to_vec())),
    }
}

/// Reads `W,S,E,N`.
pub(crate) fn bounds(text: &str) -> Result<[f64; 4], String> {
    numbers(text, "W,S,E,N in units of the coordinate system")
}

/// Reads `WxH` in pixels.
pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    const MOST: u32 = 16_384;
    let wrong = || format!("expected WxH of 1 to {MOST} pixels each, found {text:?}");
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or_else(wrong)?;
    let side = |text: &str| {
        text.trim()
            .parse()
            .ok()
            .filter(|s| (1..=MOST).contains(s))
            .ok_or_else(wrong)
    };
    Ok([side(width)?, side(height)?])
}

/// Reads a share, 0 to 1.
pub(crate) fn share(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if (0.0..=1.0).contains(&value) => Ok(value),
        _ => Err(format!("expected a number from 0 to 1, found {text:?}")),
    }
}

/// Reads a positive number.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err(format!("expected a positive number, found {text:?}")),
    }
}

fn numbers<const N: usize>(text: &str, expected: &str) -> Result<[f64; N], String> {
    let wrong = || format!("expected {expected}, found {text:?}");
    let values: Option<Vec<f64>> = text
        .split(',')
        .map(|t| t.trim().parse().ok().filter(|v: &f64| v.is_finite()))
        .collect();
    values
        .ok_or_else(wrong)?
        .try_into()
        .map_err(|_other_count: Vec<f64>| wrong())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_and_bad_ones_say_what_was_expected() {
        assert_eq!(
            place("-111.5, 40.25"),
            Ok(Place {
                lon_deg: -111.5,
                lat_deg: 40.25
            })
        );
        assert_eq!(size("1280x960"), Ok([1280, 960]));
        assert_eq!(line("1,2;-3,4").map(|l| l.0.len()), Ok(2));
        assert!(line("1,2").is_err() && line("1,2;").is_err());
        assert_eq!(bounds("1,2,3,-4e1"), Ok([1.0, 2.0, 3.0, -40.0]));
        for wrong in [
            place("1").err(),
            place("1,2,3").err(),
            place("nan,1").err(),
            place("1,91").err(),
        ] {
            assert!(wrong.unwrap().starts_with("expected"));
        }
        for wrong in ["", "0x1", "1x", "99999x1", "1x-2", "axb"] {
            assert!(
                size(wrong).unwrap_err().starts_with("expected WxH"),
                "{wrong}"
            );
        }
        for wrong in ["0", "-1", "inf", "x"] {
            assert!(positive(wrong).is_err());
        }
    }
}
