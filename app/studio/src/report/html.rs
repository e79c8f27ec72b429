//! A comparison as one page that needs nothing else.

use core::fmt::Write;

use relievo_engine::analysis::{
    Amount, ComparisonReport, DIFFERENCE_COLOURS, Picture, SitePictures, Volumes,
};

use super::table::QUANTITIES;

const STYLE: &str = "
:root { color-scheme: light dark; --line: #8884; --faint: #888; }
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 76rem; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: 0; } h2 { font-size: 1.1rem; margin-top: 2rem; }
p.sub, figcaption, .error, footer { color: var(--faint); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .35rem .6rem; border-bottom: 1px solid var(--line); text-align: right; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; white-space: normal; }
thead th { vertical-align: bottom; font-weight: 600; }
tr.total td { font-weight: 600; border-top: 2px solid; border-bottom: 0; }
.error { font-weight: 400; font-size: .8rem; display: block; }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(18rem, 1fr)); gap: 1rem; }
figure { margin: 0; } img { width: 100%; display: block; border-radius: 3px; }
.legend { height: .8rem; border-radius: 3px; margin-top: .4rem; }
.ticks { display: flex; justify-content: space-between; font-size: .8rem; }
";

/// Heads of columns, in the order of [`QUANTITIES`].
const HEADS: [&str; 8] = [
    "Cut<br>m³",
    "Fill<br>m³",
    "Net<br>m³",
    "Plan area<br>m²",
    "Surface area<br>m²",
    "Highest cut<br>m",
    "Highest fill<br>m",
    "Mean slope<br>°",
];

/// The page.
pub(super) fn page(
    title: &str,
    report: &ComparisonReport,
    sites: &[SitePictures],
) -> Result<String, png::EncodingError> {
    let [a, b] = [escaped(&report.names[0]), escaped(&report.names[1])];
    let title = escaped(title);
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{title}: {a} and {b}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <h1>{title}</h1>\n<p class=\"sub\">From <b>{a}</b> to <b>{b}</b></p>\n"
    );
    html += "<div class=\"scroll\"><table>\n<thead><tr><th>Element</th>";
    for head in HEADS {
        html.extend(["<th>", head, "</th>"]);
    }
    html += "</tr></thead>\n<tbody>\n";
    for element in &report.elements {
        let name = if element.name.is_empty() {
            &element.id.0
        } else {
            &element.name
        };
        let label = format!(
            "{}<span class=\"error\">{} {}</span>",
            escaped(name),
            escaped(&element.kind),
            element.step.name()
        );
        html += &row("", &label, &element.volumes);
    }
    html += &row(" class=\"total\"", "Total", &report.total);
    html += "</tbody>\n</table></div>\n";
    for note in &report.notes {
        html.extend(["<p>", &escaped(note), "</p>\n"]);
    }
    for site in sites {
        html += &pictures(site, &a, &b)?;
    }
    html += "<footer><p>Small grey numbers are discretisation errors. Volumes and areas are those on the \
             ellipsoid; the ground is interpolated between the samples of its data. Cut is ground taken away, fill \
             ground put on.</p></footer>\n</body>\n</html>\n";
    Ok(html)
}

fn row(class: &str, label: &str, volumes: &Volumes) -> String {
    let mut html = format!("<tr{class}><td>{label}</td>");
    for (_, of, digits) in QUANTITIES {
        let Amount { value, error } = of(volumes);
        // Writing to a string never fails.
        let _always = write!(
            html,
            "<td>{}<span class=\"error\">± {}</span></td>",
            grouped(value, digits),
            grouped(error, digits)
        );
    }
    html + "</tr>\n"
}

/// A number with thin spaces between thousands.
pub(crate) fn grouped(value: f64, digits: usize) -> String {
    let text = format!("{:.digits$}", value.abs());
    let (whole, part) = text.split_once('.').unwrap_or((&text, ""));
    let mut out = String::new();
    if value < 0.0 && text.bytes().any(|b| (b'1'..=b'9').contains(&b)) {
        out.push('−');
    }
    for (i, digit) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    if part.is_empty() {
        out
    } else {
        format!("{out}.{part}")
    }
}

fn pictures(site: &SitePictures, a: &str, b: &str) -> Result<String, png::EncodingError> {
    let (lon, lat) = site.centre_deg;
    let mut html = format!(
        "<h2>{:.5}° {}, {:.5}° {}, {} m across</h2>\n<div class=\"pictures\">\n",
        lat.abs(),
        if lat < 0.0 { "S" } else { "N" },
        lon.abs(),
        if lon < 0.0 { "W" } else { "E" },
        grouped(site.width_m, 0)
    );
    for (picture, caption) in [(&site.a, a), (&site.b, b)] {
        html += &figure(picture, caption, "")?;
    }
    let stops: Vec<String> = DIFFERENCE_COLOURS
        .iter()
        .map(|[r, g, b]| format!("rgb({r},{g},{b})"))
        .collect();
    let digits = if site.range_m < 1.0 { 3 } else { 1 };
    let range = grouped(site.range_m, digits);
    let legend = format!(
        "<div class=\"legend\" style=\"background:linear-gradient(to right,{})\"></div>\
         <div class=\"ticks\"><span>−{range} m cut</span><span>0</span><span>+{range} m fill</span></div>",
        stops.join(",")
    );
    html += &figure(
        &site.difference,
        &format!("Height of {b} minus {a}"),
        &legend,
    )?;
    Ok(html + "</div>\n")
}

fn figure(picture: &Picture, caption: &str, legend: &str) -> Result<String, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width, picture.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&picture.rgb)?;
    writer.finish()?;
    Ok(format!(
        "<figure><img alt=\"{caption}, from above\" src=\"data:image/png;base64,{}\">{legend}<figcaption>{caption}</figcaption></figure>\n",
        base64(&bytes)
    ))
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for i in 0..4 {
            if i <= chunk.len() {
                text.push(char::from(DIGITS[(bits >> (18 - 6 * i) & 63) as usize]));
            } else {
                text.push('=');
            }
        }
    }
    text
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_written_as_rfc_4648_says() {
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn numbers_are_grouped_and_nothing_is_less_than_nothing() {
        assert_eq!(grouped(1_234_567.891, 1), "1\u{202f}234\u{202f}567.9");
        assert_eq!(grouped(-12.0, 0), "−12");
        assert_eq!(grouped(-0.001, 2), "0.00");
    }
}
