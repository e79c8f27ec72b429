//! Everything that decides an element, as a sequence of numbers in which no two elements collide.

use relievo_planet::MapPoint;

use crate::element::{Element, Profile, Section, Shape, Stroke, Surface, Tool, Vertex};

fn place(p: MapPoint, add: &mut dyn FnMut(f64)) {
    add(p.lon_rad);
    add(p.colat_rad);
}

fn vertices(all: &[Vertex], add: &mut dyn FnMut(f64)) {
    add(all.len() as f64);
    for v in all {
        place(v.place, add);
        add(f64::from(u8::from(v.height_m.is_some())));
        add(v.height_m.unwrap_or(0.0));
    }
}

fn lists(all: &[Vec<Vertex>], add: &mut dyn FnMut(f64)) {
    add(all.len() as f64);
    for list in all {
        vertices(list, add);
    }
}

fn numbers<const N: usize>(all: [f64; N], add: &mut dyn FnMut(f64)) {
    for v in all {
        add(v);
    }
}

fn surface(surface: &Surface, add: &mut dyn FnMut(f64)) {
    match *surface {
        Surface::Platform { height_m } => numbers([0.0, height_m], add),
        Surface::Plane {
            height_m,
            slope_percent,
            aspect_deg,
        } => numbers([1.0, height_m, slope_percent, aspect_deg], add),
        Surface::Tin => add(2.0),
        Surface::Offset { offset_m } => numbers([3.0, offset_m], add),
        Surface::Smooth => add(4.0),
    }
}

fn section(section: &Section, add: &mut dyn FnMut(f64)) {
    match *section {
        Section::Road {
            width_m,
            crossfall_percent,
        } => numbers([0.0, width_m, crossfall_percent], add),
        Section::Dam { crest_width_m } => numbers([1.0, crest_width_m], add),
        Section::Trench {
            bottom_width_m,
            depth_m,
        } => numbers([2.0, bottom_width_m, depth_m], add),
        Section::Channel {
            bottom_width_m,
            depth_m,
            bank_slope,
        } => numbers([3.0, bottom_width_m, depth_m, bank_slope], add),
    }
}

fn stroke(stroke: &Stroke, add: &mut dyn FnMut(f64)) {
    match stroke.tool {
        Tool::Raise { strength_m } => numbers([0.0, strength_m], add),
        Tool::Lower { strength_m } => numbers([1.0, strength_m], add),
        Tool::Flatten { height_m, strength } => numbers([2.0, height_m, strength], add),
        Tool::Smooth { strength } => numbers([3.0, strength], add),
    }
    numbers([stroke.radius_m, stroke.hardness], add);
    add(stroke.points.len() as f64);
    for p in &stroke.points {
        place(*p, add);
    }
}

pub(crate) fn element(element: &Element, add: &mut dyn FnMut(f64)) {
    match &element.shape {
        Shape::Polygon(p) => {
            add(0.0);
            vertices(&p.outline, add);
            lists(&p.holes, add);
            lists(&p.breaklines, add);
            surface(&p.surface, add);
        }
        Shape::Corridor(c) => {
            add(1.0);
            vertices(&c.line, add);
            match c.profile {
                Profile::Heights => add(0.0),
                Profile::Follow { offset_m, smooth_m } => numbers([1.0, offset_m, smooth_m], add),
            }
            section(&c.section, add);
        }
        Shape::Brush(strokes) => {
            add(2.0);
            add(strokes.len() as f64);
            for s in strokes {
                stroke(s, add);
            }
            return;
        }
    }
    let side = &element.side;
    let wall = f64::from(u8::from(side.wall));
    numbers(
        [side.cut_slope, side.fill_slope, wall, side.max_reach_m],
        add,
    );
}
