//! Texts on a picture, with the letters of the window.

use epaint::emath::Align2;
use epaint::text::{FontDefinitions, Fonts, TextOptions};
use epaint::{Color32, FontId, pos2, vec2};
use relievo_engine::PlacedLabel;
use relievo_gpu::Picture;

/// Offsets at which a text is drawn for its halo, in parts of its size.
pub(crate) const AROUND: [[f32; 2]; 8] = [
    [-1.0, 0.0],
    [1.0, 0.0],
    [0.0, -1.0],
    [0.0, 1.0],
    [-0.7, -0.7],
    [0.7, -0.7],
    [-0.7, 0.7],
    [0.7, 0.7],
];

/// Width of a halo in parts of the letters' height.
pub(crate) const HALO: f32 = 0.09;

/// Draws texts over a picture, each around its place.
pub(crate) fn draw(picture: &mut Picture, labels: &[PlacedLabel]) {
    if labels.is_empty() {
        return;
    }
    let mut fonts = Fonts::new(TextOptions::default(), FontDefinitions::default());
    for label in labels {
        let size = label.size_px as f32;
        let mut view = fonts.with_pixels_per_point(1.0);
        let font = FontId::proportional(size);
        let galley = view.layout_no_wrap(label.text.clone(), font, Color32::WHITE);
        // Letters that were met for the first time are in it now.
        let letters = view.image();
        let middle = pos2(label.centre_px.x as f32, label.centre_px.y as f32);
        let corner = Align2::CENTER_CENTER.anchor_size(middle, galley.size()).min;
        let mut write = |by: [f32; 2], colour: [u8; 3]| {
            let corner = corner + vec2(by[0], by[1]);
            for row in &galley.rows {
                for glyph in &row.glyphs {
                    let uv = &glyph.uv_rect;
                    let at = corner + row.pos.to_vec2() + glyph.pos.to_vec2() + uv.offset;
                    let (left, top) = (at.x.round() as i64, at.y.round() as i64);
                    for v in uv.min[1]..uv.max[1] {
                        for u in uv.min[0]..uv.max[0] {
                            let covered = letters[(usize::from(u), usize::from(v))].a();
                            let x = left + i64::from(u - uv.min[0]);
                            let y = top + i64::from(v - uv.min[1]);
                            blend(picture, x, y, colour, covered);
                        }
                    }
                }
            }
        };
        if let Some(halo) = label.halo {
            for [x, y] in AROUND {
                write([x * size * HALO, y * size * HALO], halo);
            }
        }
        write([0.0, 0.0], label.colour);
    }
}

/// Puts a colour over a pixel, if the picture has it.
fn blend(picture: &mut Picture, x: i64, y: i64, colour: [u8; 3], covered: u8) {
    let (width, height) = (i64::from(picture.width), i64::from(picture.height));
    if covered == 0 || !(0..width).contains(&x) || !(0..height).contains(&y) {
        return;
    }
    let first = 4 * (y * width + x) as usize;
    let over = u32::from(covered);
    for (below, above) in picture.rgba[first..first + 3].iter_mut().zip(colour) {
        let mixed = u32::from(above) * over + u32::from(*below) * (255 - over);
        *below = ((mixed + 127) / 255) as u8;
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use relievo_engine::planet::MapPoint;
    use relievo_engine::project::LayerId;

    use super::*;

    #[test]
    fn a_text_lies_around_its_place_with_its_halo_about_it() {
        let (width, height) = (80, 40);
        let grey = [90, 90, 90, 255];
        let mut picture = Picture {
            width,
            height,
            rgba: grey.repeat((width * height) as usize),
        };
        let label = |x: f64, y: f64| PlacedLabel {
            layer: LayerId::from("towns"),
            text: "Provo".to_owned(),
            at: MapPoint::new(0.0, 1.0),
            centre_px: DVec2::new(x, y),
            size_px: 14.0,
            colour: [255, 0, 0],
            halo: Some([255, 255, 255]),
        };
        // One beyond the edge, of which a part shows.
        draw(&mut picture, &[label(40.0, 20.0), label(80.0, 5.0)]);
        let is = |x: u32, y: u32, c: [u8; 3]| picture.pixel(x, y)[..3] == c;
        let all = |y: core::ops::Range<u32>| y.flat_map(|y| (20..60).map(move |x| (x, y)));
        let red = all(8..32).filter(|(x, y)| {
            let [r, g, b, _] = picture.pixel(*x, *y);
            r > 200 && g < 100 && b < 100
        });
        assert!(red.count() > 15);
        let white = all(8..32).filter(|(x, y)| is(*x, *y, [255; 3])).count();
        assert!(white > 20, "{white}");
        assert!(is(2, 20, [90; 3]) && is(40, 36, [90; 3]));
        assert!((60..80).any(|x| !is(x, 5, [90; 3])));
    }
}
