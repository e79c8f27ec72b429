//! Solvers of a smooth infill on a square mesh whose solution is known.
//!
//! On a square mesh linear finite elements are the five-point formula, which x² − y² fulfils exactly: all
//! error is the solver's.

use core::hint::black_box;

use glam::DVec2;
use relievo_engine::earthwork::harmonic;

use crate::timing::in_turns;
use crate::{Chart, Content, Context, Curve, Figure, Point, Report, SuiteError, Work};

/// What stands for no error at all on a logarithmic axis.
const NONE: f64 = 1e-16;

/// A square mesh with known heights around it.
struct Mesh {
    /// Nodes along a side, with those around.
    side: usize,
    /// The exact heights, metres.
    exact_m: Vec<f64>,
}

impl Mesh {
    fn new(inside: usize) -> Self {
        let side = inside + 2;
        let at = |i: usize| 2.0 * i as f64 / (side - 1) as f64 - 1.0;
        let height = |k: usize| {
            let (x, y) = (at(k % side), at(k / side));
            500.0 + 100.0 * (x * x - y * y)
        };
        Self {
            side,
            exact_m: (0..side * side).map(height).collect(),
        }
    }

    fn is_known(&self, k: usize) -> bool {
        let (x, y) = (k % self.side, k / self.side);
        x == 0 || y == 0 || x + 1 == self.side || y + 1 == self.side
    }

    fn unknown(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.side * self.side).filter(|k| !self.is_known(*k))
    }

    /// The known heights, and their mean elsewhere.
    fn start(&self) -> Vec<f64> {
        let known = (0..self.exact_m.len()).filter(|k| self.is_known(*k));
        let (sum, count) = known.fold((0.0, 0.0), |(s, n), k| (s + self.exact_m[k], n + 1.0));
        let start = |k: usize| {
            if self.is_known(k) {
                self.exact_m[k]
            } else {
                sum / count
            }
        };
        (0..self.exact_m.len()).map(start).collect()
    }

    fn error_m(&self, found: &[f64]) -> f64 {
        let errors = found.iter().zip(&self.exact_m).map(|(a, b)| (a - b).abs());
        errors.fold(NONE, f64::max)
    }

    /// Largest deviation from the mean of the neighbours, metres.
    fn residual_m(&self, found: &[f64]) -> f64 {
        let residuals = self
            .unknown()
            .map(|k| (neighbours(found, k, self.side) / 4.0 - found[k]).abs());
        residuals.fold(NONE, f64::max)
    }

    /// As the program solves: eliminated in a nested order, without a subtraction.
    fn direct(&self) -> Vec<f64> {
        let side = self.side;
        let at = |k: usize| DVec2::new((k % side) as f64, (k / side) as f64);
        let at: Vec<DVec2> = (0..side * side).map(at).collect();
        let corners = (0..side * side).filter(|k| k % side + 1 < side && k / side + 1 < side);
        let triangles: Vec<[usize; 3]> = corners
            .flat_map(|k| [[k, k + 1, k + side], [k + 1, k + side + 1, k + side]])
            .collect();
        let known = |k: usize| self.is_known(k).then_some(self.exact_m[k]);
        let known: Vec<Option<f64>> = (0..side * side).map(known).collect();
        harmonic(&at, &triangles, &known)
    }

    fn gauss_seidel(&self, sweeps: usize) -> Vec<f64> {
        let mut x = self.start();
        let nothing = vec![0.0; x.len()];
        for _ in 0..sweeps {
            sweep(&mut x, &nothing, self.side);
        }
        x
    }

    fn conjugate_gradients(&self, steps: usize) -> Vec<f64> {
        let (side, mut x) = (self.side, self.start());
        let mut residual = vec![0.0; x.len()];
        for k in self.unknown() {
            residual[k] = neighbours(&x, k, side) - 4.0 * x[k];
        }
        let mut direction = residual.clone();
        let mut product = vec![0.0; x.len()];
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let mut size = dot(&residual, &residual);
        for _ in 0..steps {
            for k in self.unknown() {
                product[k] = 4.0 * direction[k] - neighbours(&direction, k, side);
            }
            let curvature = dot(&direction, &product);
            if curvature <= 0.0 {
                break;
            }
            let step = size / curvature;
            for k in self.unknown() {
                x[k] += step * direction[k];
                residual[k] -= step * product[k];
            }
            let next = dot(&residual, &residual);
            let keep = next / size;
            for (d, r) in direction.iter_mut().zip(&residual) {
                *d = r + keep * *d;
            }
            size = next;
        }
        x
    }

    fn multigrid(&self, cycles: usize) -> Vec<f64> {
        let mut x = self.start();
        let nothing = vec![0.0; x.len()];
        for _ in 0..cycles {
            v_cycle(&mut x, &nothing, self.side);
        }
        x
    }
}

fn neighbours(x: &[f64], k: usize, side: usize) -> f64 {
    x[k - 1] + x[k + 1] + x[k - side] + x[k + side]
}

/// One Gauss-Seidel sweep of 4 x − neighbours = `right`.
fn sweep(x: &mut [f64], right: &[f64], side: usize) {
    for row in 1..side - 1 {
        for k in row * side + 1..(row + 1) * side - 1 {
            x[k] = (neighbours(x, k, side) + right[k]) / 4.0;
        }
    }
}

/// Two sweeps, the coarser mesh's correction (full weighting, bilinear), two sweeps. `side` is a power of
/// two and one.
fn v_cycle(x: &mut [f64], right: &[f64], side: usize) {
    if side <= 3 {
        sweep(x, right, side);
        return;
    }
    sweep(x, right, side);
    sweep(x, right, side);
    let mut residual = vec![0.0; x.len()];
    for row in 1..side - 1 {
        for k in row * side + 1..(row + 1) * side - 1 {
            residual[k] = right[k] + neighbours(x, k, side) - 4.0 * x[k];
        }
    }
    let coarse = side / 2 + 1;
    let mut coarse_right = vec![0.0; coarse * coarse];
    for row in 1..coarse - 1 {
        for column in 1..coarse - 1 {
            let k = 2 * row * side + 2 * column;
            let diagonal = residual[k - side - 1]
                + residual[k - side + 1]
                + residual[k + side - 1]
                + residual[k + side + 1];
            // Sums, not means: steps are twice as long, so equations four times as large.
            coarse_right[row * coarse + column] =
                residual[k] + 0.5 * neighbours(&residual, k, side) + 0.25 * diagonal;
        }
    }
    let mut correction = vec![0.0; coarse * coarse];
    v_cycle(&mut correction, &coarse_right, coarse);
    for row in 1..side - 1 {
        for column in 1..side - 1 {
            let (r, c) = (row / 2 * coarse, column / 2);
            let at = |down: usize, right: usize| correction[r + down * coarse + c + right];
            x[row * side + column] += match (row % 2, column % 2) {
                (0, 0) => at(0, 0),
                (0, _) => f64::midpoint(at(0, 0), at(0, 1)),
                (_, 0) => f64::midpoint(at(0, 0), at(1, 0)),
                _ => (at(0, 0) + at(0, 1) + at(1, 0) + at(1, 1)) / 4.0,
            };
        }
    }
    sweep(x, right, side);
    sweep(x, right, side);
}

/// Solves a mesh in so many steps.
type Solve = fn(&Mesh, usize) -> Vec<f64>;

/// A solver with how far it goes.
struct Setting {
    solver: &'static str,
    name: String,
    mesh: usize,
    /// So many steps of the solver.
    count: usize,
    solve: Solve,
}

fn settings(meshes: usize, most: usize) -> Vec<Setting> {
    let mut all: Vec<Setting> = (0..meshes)
        .map(|mesh| Setting {
            solver: "direct, as the program does",
            name: "solved".to_owned(),
            mesh,
            count: 1,
            solve: |mesh, _| mesh.direct(),
        })
        .collect();
    let iterated: [(&str, &str, Solve, &[usize]); 3] = [
        (
            "multigrid",
            "V-cycles",
            Mesh::multigrid,
            &[1, 2, 4, 6, 8, 12],
        ),
        (
            "conjugate gradients",
            "steps",
            Mesh::conjugate_gradients,
            &[8, 32, 64, 128, 256, 512],
        ),
        (
            "Gauss-Seidel",
            "sweeps",
            Mesh::gauss_seidel,
            &[1, 16, 64, 256, 1024, 4096],
        ),
    ];
    for (solver, unit, solve, counts) in iterated {
        for count in counts.iter().copied().filter(|count| *count <= most) {
            all.push(Setting {
                solver,
                name: format!("{count} {unit}"),
                mesh: 0,
                count,
                solve,
            });
        }
    }
    all
}

pub(super) fn measure(context: &Context) -> Result<Report, SuiteError> {
    // Powers of two less one, which multigrid takes; the first one is compared, the others scale.
    let sides: &[usize] = context.pick(&[31], &[127, 31, 63]);
    let meshes: Vec<Mesh> = sides.iter().map(|n| Mesh::new(*n)).collect();
    let settings = settings(meshes.len(), context.pick(600, usize::MAX));
    let mut errors = Vec::new();
    for setting in &settings {
        context.go_on()?;
        let mesh = &meshes[setting.mesh];
        let found = (setting.solve)(mesh, setting.count);
        errors.push((mesh.error_m(&found), mesh.residual_m(&found)));
    }
    let mut works: Vec<Work> = settings
        .iter()
        .map(|setting| {
            let mesh = &meshes[setting.mesh];
            Work::new(1e6, move || {
                black_box((setting.solve)(black_box(mesh), setting.count));
            })
        })
        .collect();
    let times = in_turns(context, &mut works)?;
    drop(works);
    let curves = |of: &dyn Fn(&(f64, f64)) -> f64| {
        let measured = settings.iter().zip(&errors).zip(&times);
        Curve::grouped(measured.map(|((setting, error), time)| {
            let nodes = sides[setting.mesh] * sides[setting.mesh];
            let point = Point::timed(setting.name.clone(), *time, of(error));
            (format!("{} ({nodes} nodes)", setting.solver), point)
        }))
    };
    let caption = "The membrane through x² − y² of ± 100 m around a square, which the five-point formula fulfils exactly: what is left is \
                   the solver's. 10⁻¹⁶ stands for none. One thread.";
    let figure = |name: &str, title: &str, error: &str, of: &dyn Fn(&(f64, f64)) -> f64| {
        let chart = Chart::trade("ms", error, "m", curves(of));
        Figure::new(name, title, caption, Content::Chart(chart))
    };
    let (direct, ms) = (errors[0].0, times[0].median);
    let nodes = sides[0] * sides[0];
    Ok(Report {
        summary: vec![format!(
            "A smooth infill of {nodes} nodes is solved in {ms:.1} ms to {direct:.0e} m by elimination without a subtraction, which keeps its \
             digits however stiff the mesh is (see the suite `stability`)."
        )],
        figures: vec![
            figure(
                "infill-height",
                "Smooth infill: error of heights",
                "largest error",
                &|e| e.0,
            ),
            figure(
                "infill-residual",
                "Smooth infill: residual",
                "largest deviation from the neighbours' mean",
                &|e| e.1,
            ),
        ],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_solver_comes_to_the_closed_form() {
        let mesh = Mesh::new(31);
        assert!(mesh.error_m(&mesh.start()) > 50.0);
        assert!(mesh.error_m(&mesh.direct()) < 1e-12);
        assert!(mesh.error_m(&mesh.multigrid(20)) < 1e-11);
        assert!(mesh.error_m(&mesh.conjugate_gradients(200)) < 1e-10);
        assert!(mesh.error_m(&mesh.gauss_seidel(5000)) < 1e-9);
    }

    #[test]
    fn a_cycle_of_multigrid_takes_nine_tenths_of_the_error_away_whatever_the_mesh() {
        for inside in [15, 31, 63] {
            let mesh = Mesh::new(inside);
            let errors = [2, 3, 4, 5].map(|cycles| mesh.error_m(&mesh.multigrid(cycles)));
            for pair in errors.windows(2) {
                assert!(pair[1] < 0.1 * pair[0], "{inside}: {errors:?}");
            }
        }
    }
}
