//! One area as a body: a roof and walls around it and its holes.

use core::f64::consts::FRAC_PI_2;

use earcut::Earcut;
use glam::{DVec2, DVec3};
use relievo_planet::MapPoint;
use relievo_vector::{Outline, Shape};

use super::{MassMesh, MassVertex};

/// Vertices of all bodies of a mesh at most: what is beyond them is left out.
pub(super) const MOST_VERTICES: usize = 2_000_000;

/// How a body stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standing {
    /// Metres of the roof above the mean height of the ground at the outline.
    pub(super) height_m: f64,
    /// sRGB red, green, blue.
    pub(super) colour: [u8; 3],
}

/// What all bodies of a mesh are built on.
pub(super) struct Site<'a> {
    /// Metres from the centre to the datum.
    pub(super) radius_m: f64,
    /// Factor on heights.
    pub(super) exaggeration: f64,
    /// Height of the ground at a place in metres, without exaggeration.
    pub(super) ground_m: &'a dyn Fn(MapPoint) -> f64,
}

/// Adds the areas of one feature to a mesh; lines, points and rings around a pole are no bodies.
pub(super) fn add<'o>(
    mesh: &mut MassMesh,
    outlines: impl Iterator<Item = Outline<'o>>,
    standing: Standing,
    site: &Site,
) {
    let mut area: Vec<Outline> = Vec::new();
    for outline in outlines {
        match outline.shape {
            Shape::Outer => {
                add_area(mesh, &area, standing, site);
                area.clear();
                if outline.pole == 0 {
                    area.push(outline);
                }
            }
            Shape::Hole if !area.is_empty() => area.push(outline),
            Shape::Hole | Shape::Points | Shape::Line => {}
        }
    }
    add_area(mesh, &area, standing, site);
}

fn place(lonlat: DVec2) -> MapPoint {
    MapPoint::new(lonlat.x, FRAC_PI_2 - lonlat.y).normalised()
}

/// A ring without its closing vertex and without vertices that repeat.
fn open_ring(outline: &Outline) -> Vec<DVec2> {
    let mut ring: Vec<DVec2> = outline.lonlat_rad.to_vec();
    ring.dedup();
    if ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    ring
}

/// Twice the area that a ring encloses, positive for one that runs counterclockwise.
fn doubled_area(ring: &[DVec2]) -> f64 {
    let around = ring.iter().zip(ring.iter().cycle().skip(1));
    let origin = ring.first().copied().unwrap_or_default();
    around
        .map(|(a, b)| (*a - origin).perp_dot(*b - origin))
        .sum()
}

fn add_area(mesh: &mut MassMesh, area: &[Outline], standing: Standing, site: &Site) {
    let mut rings: Vec<Vec<DVec2>> = area.iter().map(open_ring).collect();
    if rings.first().is_none_or(|outer| outer.len() < 3) {
        return;
    }
    rings.retain(|ring| ring.len() >= 3);
    for (k, ring) in rings.iter_mut().enumerate() {
        // The inside lies at the left of every ring.
        if (doubled_area(ring) > 0.0) != (k == 0) {
            ring.reverse();
        }
    }
    let count: usize = rings.iter().map(Vec::len).sum();
    if mesh.vertices.len() + 5 * count > MOST_VERTICES {
        return;
    }
    let ground: Vec<f64> = rings
        .iter()
        .flatten()
        .map(|p| (site.ground_m)(place(*p)))
        .collect();
    let outer = &ground[..rings[0].len()];
    let mean_m = outer.iter().sum::<f64>() / outer.len() as f64;
    let lowest_m = ground.iter().fold(f64::INFINITY, |low, h| low.min(*h));
    let roof_m = mean_m + standing.height_m;
    // Walls go on below the ground, so that none shows a gap where the ground is drawn coarsely.
    let foot_m = lowest_m - (0.25 * standing.height_m).max(1.0);
    let in_world = |p: DVec2, height_m: f64| {
        place(p).to_unit() * (site.radius_m + height_m * site.exaggeration)
    };
    add_roof(mesh, &rings, standing, |p| in_world(p, roof_m));
    for ring in &rings {
        for (k, a) in ring.iter().enumerate() {
            let b = ring[(k + 1) % ring.len()];
            let corners = [
                in_world(*a, foot_m),
                in_world(b, foot_m),
                in_world(b, roof_m),
                in_world(*a, roof_m),
            ];
            let outward = (corners[1] - corners[0]).cross(corners[2] - corners[1]);
            let first = mesh.vertices.len() as u32;
            for corner in corners {
                push(mesh, corner, outward.normalize_or_zero(), standing.colour);
            }
            mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
        }
    }
}

fn add_roof(
    mesh: &mut MassMesh,
    rings: &[Vec<DVec2>],
    standing: Standing,
    on_roof: impl Fn(DVec2) -> DVec3,
) {
    let first = mesh.vertices.len() as u32;
    let origin = rings[0][0];
    let east = libm::cos(origin.y);
    let plane = rings
        .iter()
        .flatten()
        .map(|p| [(p.x - origin.x) * east, p.y - origin.y]);
    let mut holes: Vec<u32> = Vec::new();
    let mut start = rings[0].len() as u32;
    for hole in &rings[1..] {
        holes.push(start);
        start += hole.len() as u32;
    }
    let mut triangles: Vec<u32> = Vec::new();
    Earcut::new().earcut(plane, &holes, &mut triangles);
    let up = on_roof(origin).normalize_or(DVec3::Z);
    for p in rings.iter().flatten() {
        push(mesh, on_roof(*p), up, standing.colour);
    }
    for corners in triangles.as_chunks::<3>().0 {
        let at = |k: usize| {
            let v = mesh.vertices[(first + corners[k]) as usize].offset_m;
            glam::Vec3::from(v).as_dvec3()
        };
        let faces_up = (at(1) - at(0)).cross(at(2) - at(0)).dot(up) > 0.0;
        let [a, b, c] = corners.map(|i| first + i);
        mesh.indices
            .extend(if faces_up { [a, b, c] } else { [a, c, b] });
    }
}

fn push(mesh: &mut MassMesh, at: DVec3, normal: DVec3, [r, g, b]: [u8; 3]) {
    let offset = at - mesh.origin_in_world;
    mesh.radius_m = mesh.radius_m.max(offset.length());
    mesh.vertices.push(MassVertex {
        offset_m: offset.as_vec3().to_array(),
        normal: normal.as_vec3().to_array(),
        rgba: [r, g, b, 255],
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS_M: f64 = 6_371_008.8;

    fn mesh_of(rings: &[(Shape, Vec<DVec2>)], height_m: f64) -> MassMesh {
        let first = rings[0].1[0];
        let mut mesh = MassMesh {
            id: 0,
            origin_in_world: place(first).to_unit() * RADIUS_M,
            radius_m: 0.0,
            vertices: Vec::new(),
            indices: Vec::new(),
        };
        let outlines = rings.iter().map(|(shape, lonlat_rad)| Outline {
            shape: *shape,
            pole: 0,
            lonlat_rad,
        });
        let site = Site {
            radius_m: RADIUS_M,
            exaggeration: 1.0,
            ground_m: &|_| 50.0,
        };
        let standing = Standing {
            height_m,
            colour: [200, 100, 50],
        };
        add(&mut mesh, outlines, standing, &site);
        mesh
    }

    fn square(lon_deg: f64, lat_deg: f64, half_m: f64) -> Vec<DVec2> {
        let lat = lat_deg.to_radians();
        let centre = DVec2::new(lon_deg.to_radians(), lat);
        let step = DVec2::new(half_m / (RADIUS_M * lat.cos()), half_m / RADIUS_M);
        [
            (-1.0, -1.0),
            (1.0, -1.0),
            (1.0, 1.0),
            (-1.0, 1.0),
            (-1.0, -1.0),
        ]
        .map(|(x, y)| centre + DVec2::new(x, y) * step)
        .to_vec()
    }

    /// Volume by the divergence theorem: only a closed surface that faces outwards has the right one.
    fn volume_m3(mesh: &MassMesh) -> f64 {
        let at = |i: u32| glam::Vec3::from(mesh.vertices[i as usize].offset_m).as_dvec3();
        let triangles = mesh.indices.as_chunks::<3>().0;
        let six: f64 = triangles
            .iter()
            .map(|[a, b, c]| at(*a).dot(at(*b).cross(at(*c))))
            .sum();
        six / 6.0
    }

    #[test]
    fn walls_and_roof_enclose_the_area_times_its_height_but_for_the_open_foot() {
        for (lon, lat) in [(11.0, 47.0), (-179.9999, -10.0), (0.0, 89.9)] {
            let mesh = mesh_of(&[(Shape::Outer, square(lon, lat, 20.0))], 12.0);
            // The open foot lies below the origin of the sum, which is at the datum: a third of what is between.
            let foot_m = 50.0 - 3.0;
            let whole = 1600.0 * (12.0 + 3.0);
            let missing_foot = 1600.0 * foot_m / 3.0;
            let found = volume_m3(&mesh) - missing_foot;
            assert!(
                (found - whole).abs() < 0.003 * whole,
                "{lon} {lat} {found} {whole}"
            );
            assert_eq!(mesh.indices.len(), 3 * (2 + 8));
        }
    }

    #[test]
    fn holes_are_left_out_whichever_way_rings_run() {
        let outer = square(11.0, 47.0, 20.0);
        let hole = square(11.0, 47.0, 10.0);
        let turned = |ring: &[DVec2]| ring.iter().rev().copied().collect::<Vec<_>>();
        let solid = volume_m3(&mesh_of(&[(Shape::Outer, outer.clone())], 12.0));
        for (o, h) in [
            (outer.clone(), hole.clone()),
            (turned(&outer), hole.clone()),
            (outer.clone(), turned(&hole)),
        ] {
            let ring = volume_m3(&mesh_of(&[(Shape::Outer, o), (Shape::Hole, h)], 12.0));
            assert!((ring / solid - 0.75).abs() < 0.003, "{ring} {solid}");
        }
    }

    #[test]
    fn what_has_no_area_has_no_body() {
        let point = vec![DVec2::new(0.2, 0.7); 5];
        assert!(mesh_of(&[(Shape::Outer, point)], 12.0).indices.is_empty());
        let line = square(11.0, 47.0, 20.0);
        assert!(mesh_of(&[(Shape::Line, line)], 12.0).indices.is_empty());
    }
}
