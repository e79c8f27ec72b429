//! Snapping: a pointer near a vertex or an edge means that.

use eframe::egui::{Pos2, Vec2};

/// How near is near, points.
pub(super) const REACH: f32 = 9.0;

/// What a pointer is near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Near {
    /// A vertex, by its position in the list.
    Vertex(usize),
    /// An edge, by the position of its first vertex, and where on it (0 to 1).
    Edge(usize, f32),
}

/// What of a line or ring a pointer is near; vertices count before edges. Vertices that are not on
/// the screen are `None`.
pub(super) fn near(points: &[Option<Pos2>], is_ring: bool, at: Pos2) -> Option<(Near, f32)> {
    let vertices = points.iter().enumerate();
    let vertex = vertices
        .filter_map(|(i, p)| Some((Near::Vertex(i), p.as_ref()?.distance(at))))
        .filter(|(_, d)| *d <= REACH)
        .min_by(|a, b| a.1.total_cmp(&b.1));
    if vertex.is_some() {
        return vertex;
    }
    let count = points.len();
    let edges = if is_ring {
        count
    } else {
        count.saturating_sub(1)
    };
    let edge = |i: usize| {
        let (a, b) = (points[i]?, points[(i + 1) % count]?);
        let (share, distance) = on_segment(a, b, at);
        Some((Near::Edge(i, share), distance))
    };
    (0..edges)
        .filter_map(edge)
        .filter(|(_, d)| *d <= REACH)
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The place on a segment that is nearest to a point, and its distance.
pub(super) fn on_segment(a: Pos2, b: Pos2, at: Pos2) -> (f32, f32) {
    let along: Vec2 = b - a;
    let length_sq = along.length_sq();
    let share = if length_sq > 0.0 {
        ((at - a).dot(along) / length_sq).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (share, (a + along * share).distance(at))
}

/// Whether a point is inside a ring, by the even-odd rule.
pub(super) fn is_inside(ring: &[Pos2], at: Pos2) -> bool {
    let edges = ring.iter().zip(ring.iter().cycle().skip(1));
    let crossings = edges.filter(|(a, b)| {
        (a.y > at.y) != (b.y > at.y) && {
            let x = a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x);
            x > at.x
        }
    });
    crossings.count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use eframe::egui::pos2;

    use super::*;

    fn square() -> Vec<Option<Pos2>> {
        [(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0)]
            .map(|(x, y)| Some(pos2(x, y)))
            .to_vec()
    }

    #[test]
    fn vertices_count_before_edges_and_rings_close() {
        let found = |at| near(&square(), true, at).map(|(n, _)| n);
        assert_eq!(found(pos2(97.0, 4.0)), Some(Near::Vertex(1)));
        assert_eq!(found(pos2(50.0, 5.0)), Some(Near::Edge(0, 0.5)));
        assert_eq!(found(pos2(3.0, 25.0)), Some(Near::Edge(3, 0.75)));
        assert_eq!(found(pos2(50.0, 50.0)), None);
        assert_eq!(
            near(&square(), false, pos2(3.0, 25.0)),
            None,
            "a line is open"
        );
    }

    #[test]
    fn what_is_not_on_the_screen_is_not_snapped_to() {
        let mut points = square();
        points[0] = None;
        assert_eq!(near(&points, true, pos2(1.0, 1.0)), None);
        assert_eq!(near(&[], true, pos2(1.0, 1.0)), None);
    }

    #[test]
    fn inside_is_by_the_even_odd_rule() {
        let ring: Vec<Pos2> = square().into_iter().flatten().collect();
        assert!(is_inside(&ring, pos2(50.0, 50.0)));
        assert!(!is_inside(&ring, pos2(150.0, 50.0)));
        let bow_tie =
            [(0.0, 0.0), (100.0, 100.0), (100.0, 0.0), (0.0, 100.0)].map(|(x, y)| pos2(x, y));
        assert!(is_inside(&bow_tie, pos2(20.0, 50.0)) && !is_inside(&bow_tie, pos2(50.0, 10.0)));
    }
}
