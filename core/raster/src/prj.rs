//! Well-Known Text of coordinate systems, as far as it names one that is known here.
//!
//! An authority's number wins; else the usual projections are put together from their parameters,
//! in the dialects of OGC, ESRI and ISO 19162. Text that says anything else has no name here, so
//! that a file is never placed by half of what it says.
//!
//! Source: OGC 01-009 (WKT 1), ISO 19162 (WKT 2), ESRI's `.prj` beside ASCII grids.

mod tree;

use std::io::Read;
use std::path::Path;

use crate::crs::Crs;
use tree::Node;

/// Bytes of a `.prj` file at most.
const MAX_BYTES: u64 = 64 << 10;

/// The system that the file's `.prj` companion names; `None` where there is none or it is unknown.
pub(crate) fn beside(file: &Path) -> Option<String> {
    let open = |ending: &str| std::fs::File::open(file.with_extension(ending)).ok();
    let found = open("prj").or_else(|| open("PRJ"))?;
    let mut text = String::new();
    found.take(MAX_BYTES).read_to_string(&mut text).ok()?;
    let name = name_of(&text);
    if name.is_none() {
        tracing::warn!(?file, "the .prj file names no coordinate system known here");
    }
    name
}

/// The system that a text means: `EPSG:n` or a proj string.
pub(crate) fn name_of(text: &str) -> Option<String> {
    let name = match Node::parse(text) {
        Some(root) => of_tree(&root)?,
        None => of_lines(text)?,
    };
    Crs::parse(&name).is_ok().then_some(name)
}

fn of_tree(root: &Node) -> Option<String> {
    let root = match &*root.name {
        "compdcs" | "compoundcrs" => root.children.iter().find(|c| is_horizontal(c))?,
        _ => root,
    };
    if let Some(code) = authority(root) {
        return Some(code);
    }
    match &*root.name {
        "geogcs" | "geogcrs" | "geodcrs" | "geographiccrs" => {
            let figure = Figure::of(root)?;
            Some(match figure.datum {
                Some("WGS84") => "EPSG:4326".into(),
                Some("NAD83") => "EPSG:4269".into(),
                Some("NAD27") => "EPSG:4267".into(),
                _ => format!("+proj=longlat {} +no_defs", figure.text()),
            })
        }
        "projcs" | "projcrs" | "projectedcrs" => projected(root),
        _ => None,
    }
}

fn is_horizontal(node: &Node) -> bool {
    ["projcs", "projcrs", "geogcs", "geogcrs"].contains(&&*node.name)
}

/// `EPSG:n` where the node itself carries the number.
fn authority(node: &Node) -> Option<String> {
    let own = node
        .children
        .iter()
        .find(|c| c.name == "authority" || c.name == "id")?;
    let [who, number, ..] = own.values.as_slice() else {
        return None;
    };
    let code = format!(
        "{}:{}",
        who.to_ascii_uppercase(),
        number.parse::<u32>().ok()?
    );
    Crs::parse(&code).is_ok().then_some(code)
}

/// Size and shape of the planet, and the datum where proj knows it.
struct Figure {
    datum: Option<&'static str>,
    a_m: f64,
    inverse_flattening: f64,
}

impl Figure {
    fn of(system: &Node) -> Option<Self> {
        let datum = system.find(&["datum", "ensemble", "trf", "geodeticdatum"])?;
        let spheroid = system.find(&["spheroid", "ellipsoid"])?;
        let number = |i: usize| spheroid.values.get(i)?.parse::<f64>().ok();
        let (a_m, inverse_flattening) = (number(1)?, number(2)?);
        let name = tree::plain(datum.values.first()?);
        let known = [
            ("wgs1984", "WGS84"),
            ("wgs84", "WGS84"),
            ("worldgeodeticsystem1984", "WGS84"),
            ("northamerican1983", "NAD83"),
            ("northamericandatum1983", "NAD83"),
            ("northamerican1927", "NAD27"),
            ("northamericandatum1927", "NAD27"),
        ];
        // ESRI's names begin with `D_`.
        let found = known
            .iter()
            .find(|(n, _)| name == *n || name == format!("d{n}") || name == format!("{n}ensemble"));
        let greenwich = system
            .find(&["primem", "primemeridian"])
            .and_then(|p| p.values.get(1)?.parse::<f64>().ok())
            .is_none_or(|lon| lon == 0.0);
        greenwich.then_some(Self {
            datum: found.map(|(_, datum)| *datum),
            a_m,
            inverse_flattening,
        })
    }

    fn text(&self) -> String {
        match self.datum {
            Some(datum) => format!("+datum={datum}"),
            None if self.inverse_flattening == 0.0 => format!("+R={}", self.a_m),
            None => format!("+a={} +rf={}", self.a_m, self.inverse_flattening),
        }
    }
}

/// The proj string of a projected system.
fn projected(system: &Node) -> Option<String> {
    let figure = Figure::of(system)?;
    let method = system.find(&["projection", "method"])?.values.first()?;
    let method = tree::plain(method);
    let parameter = |names: &[&str]| {
        system.all("parameter").into_iter().find_map(|p| {
            let name = tree::plain(p.values.first()?);
            names
                .contains(&&*name)
                .then(|| p.values.get(1)?.parse::<f64>().ok())?
        })
    };
    let lon_0 = parameter(&[
        "centralmeridian",
        "longitudeofcenter",
        "longitudeoforigin",
        "longitudeofnaturalorigin",
        "longitudeoffalseorigin",
    ])
    .unwrap_or(0.0);
    let lat_0 = parameter(&[
        "latitudeoforigin",
        "latitudeofcenter",
        "latitudeofnaturalorigin",
        "latitudeoffalseorigin",
    ]);
    let parallel = parameter(&["standardparallel1", "latitudeof1ststandardparallel"]);
    let parallel_2 = parameter(&["standardparallel2", "latitudeof2ndstandardparallel"]);
    let k_0 = parameter(&["scalefactor", "scalefactoratnaturalorigin"]).unwrap_or(1.0);
    // Linear parameters are in the system's unit, proj wants metres.
    let unit_m = system
        .children
        .iter()
        .filter(|c| c.name == "unit" || c.name == "lengthunit")
        .find_map(|u| u.values.get(1)?.parse::<f64>().ok())
        .or_else(|| {
            let unit = system.find(&["lengthunit"])?;
            unit.values.get(1)?.parse::<f64>().ok()
        })
        .unwrap_or(1.0);
    let x_0 = parameter(&["falseeasting", "eastingatfalseorigin"]).unwrap_or(0.0) * unit_m;
    let y_0 = parameter(&["falsenorthing", "northingatfalseorigin"]).unwrap_or(0.0) * unit_m;
    let lat = lat_0.unwrap_or(0.0);
    let main = match &*method {
        "transversemercator" | "gausskruger" => format!("+proj=tmerc +lat_0={lat} +k={k_0}"),
        "lambertconformalconic" | "lambertconformalconic2sp" | "lambertconicconformal2sp" => {
            let first = parallel.or(lat_0)?;
            let second = parallel_2.unwrap_or(first);
            format!("+proj=lcc +lat_0={lat} +lat_1={first} +lat_2={second} +k_0={k_0}")
        }
        "lambertconformalconic1sp" | "lambertconicconformal1sp" => {
            format!("+proj=lcc +lat_0={lat} +lat_1={lat} +k_0={k_0}")
        }
        "albers" | "albersconicequalarea" | "albersequalarea" => {
            format!(
                "+proj=aea +lat_0={lat} +lat_1={} +lat_2={}",
                parallel?, parallel_2?
            )
        }
        "lambertazimuthalequalarea" => format!("+proj=laea +lat_0={lat}"),
        "mercatorauxiliarysphere" | "popularvisualisationpseudomercator" => {
            return (lon_0 == 0.0 && unit_m == 1.0).then(|| "EPSG:3857".to_owned());
        }
        "mercator" | "mercator2sp" | "mercatorvariantb" => {
            format!("+proj=merc +lat_ts={}", parallel.unwrap_or(0.0))
        }
        "mercator1sp" | "mercatorvarianta" => format!("+proj=merc +k={k_0}"),
        "stereographicnorthpole" => format!("+proj=stere +lat_0=90 +lat_ts={}", parallel?),
        "stereographicsouthpole" => format!("+proj=stere +lat_0=-90 +lat_ts={}", parallel?),
        "polarstereographic" => {
            // OGC puts the parallel of true scale where others have the origin.
            let pole = if lat < 0.0 { -90 } else { 90 };
            format!("+proj=stere +lat_0={pole} +lat_ts={lat} +k={k_0}")
        }
        "equidistantcylindrical" | "equirectangular" | "platecarree" => {
            format!("+proj=eqc +lat_ts={}", parallel.unwrap_or(0.0))
        }
        "cylindricalequalarea" => format!("+proj=cea +lat_ts={}", parallel.unwrap_or(0.0)),
        "sinusoidal" => "+proj=sinu".to_owned(),
        _ => return None,
    };
    let utm = utm(&figure, &method, [lon_0, lat, k_0, x_0, y_0, unit_m]);
    Some(utm.unwrap_or_else(|| {
        format!(
            "{main} +lon_0={lon_0} +x_0={x_0} +y_0={y_0} {} +to_meter={unit_m} +no_defs",
            figure.text()
        )
    }))
}

/// The number of a zone of the Universal Transverse Mercator system.
fn utm(
    figure: &Figure,
    method: &str,
    [lon_0, lat_0, k_0, x_0, y_0, unit_m]: [f64; 6],
) -> Option<String> {
    let zone = (lon_0 + 183.0) / 6.0;
    let is_zone = method == "transversemercator"
        && (1.0..=60.0).contains(&zone)
        && zone == libm::floor(zone)
        && (lat_0, k_0, x_0, unit_m) == (0.0, 0.9996, 500_000.0, 1.0);
    let south = y_0 == 1e7;
    if !is_zone || !(south || y_0 == 0.0) {
        return None;
    }
    let first = match (figure.datum?, south) {
        ("WGS84", false) => 32_600,
        ("WGS84", true) => 32_700,
        ("NAD83", false) => 26_900,
        ("NAD27", false) => 26_700,
        _ => return None,
    };
    let code = format!("EPSG:{}", first + zone as u32);
    Crs::parse(&code).is_ok().then_some(code)
}

/// The older form of ARC/INFO: a keyword and a value a line.
fn of_lines(text: &str) -> Option<String> {
    let value = |key: &str| {
        text.lines().find_map(|line| {
            let (name, value) = line.trim().split_once(char::is_whitespace)?;
            name.eq_ignore_ascii_case(key)
                .then(|| value.trim().to_ascii_uppercase())
        })
    };
    let first = match value("datum")?.as_str() {
        "WGS84" | "WGS_1984" => (32_600, 4326),
        "NAD83" => (26_900, 4269),
        "NAD27" => (26_700, 4267),
        _ => return None,
    };
    let units = value("units").unwrap_or_default();
    match value("projection")?.as_str() {
        "GEOGRAPHIC" if units == "DD" || units.is_empty() => Some(format!("EPSG:{}", first.1)),
        "UTM" if units.starts_with("METER") => {
            let zone: u32 = value("zone")?.parse().ok()?;
            let unshifted = |key| value(key).is_none_or(|v| v.parse() == Ok(0.0));
            ((1..=60).contains(&zone) && unshifted("xshift") && unshifted("yshift"))
                .then(|| format!("EPSG:{}", first.0 + zone))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WGS84: &str = r#"GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]]"#;

    #[test]
    fn geographic_systems_have_their_usual_numbers() {
        assert_eq!(name_of(WGS84).as_deref(), Some("EPSG:4326"));
        let mars = r#"GEOGCS["GCS_Mars_2000",DATUM["D_Mars_2000",SPHEROID["Mars_2000_IAU_IAG",3396190.0,169.8944472236118]],PRIMEM["Reference_Meridian",0.0],UNIT["Degree",0.0174532925199433]]"#;
        let name = name_of(mars).unwrap();
        assert!(name.contains("+a=3396190"), "{name}");
    }

    #[test]
    fn an_authority_at_the_root_wins_and_one_further_down_does_not() {
        let tail = r#"PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",-111],PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1]"#;
        let inner = WGS84.replace("UNIT[", r#"AUTHORITY["EPSG","4326"],UNIT["#);
        let with = format!(r#"PROJCS["any",{inner},{tail},AUTHORITY["EPSG","26912"]]"#);
        assert_eq!(name_of(&with).as_deref(), Some("EPSG:26912"));
        let without = format!(r#"PROJCS["any",{inner},{tail}]"#);
        assert_eq!(name_of(&without).as_deref(), Some("EPSG:32612"));
    }

    /// The same point through the text and through the number that the text means.
    fn agrees(text: &str, code: &str, lon_deg: f64, lat_deg: f64) {
        let name = name_of(text).unwrap();
        let (lon, lat) = (lon_deg.to_radians(), lat_deg.to_radians());
        let at = |name: &str| Crs::parse(name).unwrap().from_lonlat(lon, lat).unwrap();
        let (found, expected) = (at(&name), at(code));
        let distance = (found.0 - expected.0).hypot(found.1 - expected.1);
        assert!(distance < 0.01, "{name}: {found:?} instead of {expected:?}");
    }

    #[test]
    fn projections_in_esri_dialect_lie_where_their_numbers_do() {
        let etrs = r#"GEOGCS["GCS_ETRS_1989",DATUM["D_ETRS_1989",SPHEROID["GRS_1980",6378137.0,298.257222101]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]]"#;
        agrees(
            &format!(
                r#"PROJCS["ETRS_1989_LAEA",{etrs},PROJECTION["Lambert_Azimuthal_Equal_Area"],PARAMETER["False_Easting",4321000.0],PARAMETER["False_Northing",3210000.0],PARAMETER["Central_Meridian",10.0],PARAMETER["Latitude_Of_Origin",52.0],UNIT["Meter",1.0]]"#
            ),
            "EPSG:3035",
            8.0,
            47.0,
        );
        agrees(
            &format!(
                r#"PROJCS["South",{WGS84},PROJECTION["Stereographic_South_Pole"],PARAMETER["False_Easting",0.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",0.0],PARAMETER["Standard_Parallel_1",-71.0],UNIT["Meter",1.0]]"#
            ),
            "EPSG:3031",
            78.0,
            -68.5,
        );
        let nad83 = r#"GEOGCS["GCS_North_American_1983",DATUM["D_North_American_1983",SPHEROID["GRS_1980",6378137.0,298.257222101]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]]"#;
        // Central Utah in US survey feet.
        agrees(
            &format!(
                r#"PROJCS["Utah_C",{nad83},PROJECTION["Lambert_Conformal_Conic"],PARAMETER["False_Easting",1640416.666666667],PARAMETER["False_Northing",6561666.666666666],PARAMETER["Central_Meridian",-111.5],PARAMETER["Standard_Parallel_1",39.01666666666667],PARAMETER["Standard_Parallel_2",40.65],PARAMETER["Latitude_Of_Origin",38.33333333333334],UNIT["Foot_US",0.3048006096012192]]"#
            ),
            "EPSG:3566",
            -111.8,
            40.2,
        );
    }

    #[test]
    fn the_older_form_names_utm_zones_and_degrees() {
        let utm = "Projection    UTM\nZone          12\nDatum         NAD83\nZunits        NO\nUnits         METERS\nXshift 0.0\nYshift 0.0\nParameters\n";
        assert_eq!(name_of(utm).as_deref(), Some("EPSG:26912"));
        let degrees = "projection geographic\ndatum WGS84\nunits DD\n";
        assert_eq!(name_of(degrees).as_deref(), Some("EPSG:4326"));
    }

    #[test]
    fn anything_else_has_no_name() {
        let deep = "A[".repeat(100_000);
        for text in [
            "",
            "PROJCS",
            "GEOGCS[\"x\"]",
            "{}",
            &deep,
            "PROJCS[\"a\",,]",
            "a b\nc d",
        ] {
            assert_eq!(name_of(text), None);
        }
    }
}
