//! Several overlapping pictures brought to one look at once.

use super::ColourPair;
use super::ground::CommonGround;

/// What two pictures show of the same ground, a channel at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Index of one picture.
    pub first: usize,
    /// Index of the other.
    pub second: usize,
    /// Means of the display values of red, green and blue, 0 to 1, of the first.
    pub first_mean: [f64; 3],
    /// Standard deviations of the first.
    pub first_deviation: [f64; 3],
    /// Means of the second.
    pub second_mean: [f64; 3],
    /// Standard deviations of the second.
    pub second_deviation: [f64; 3],
    /// How much it counts, above 0: the number of places.
    pub weight: f64,
}

impl CommonGround {
    /// What it says of two pictures.
    pub fn overlap(&self, first: usize, second: usize) -> Overlap {
        let weight: f64 = self.weights.iter().sum();
        let moments = |of: &dyn Fn(&ColourPair) -> [f32; 3], channel: usize| {
            let sum = |f: &dyn Fn(f64) -> f64| {
                let each = self.pairs.iter().zip(&self.weights);
                each.map(|(pair, w)| w * f(f64::from(of(pair)[channel])))
                    .sum::<f64>()
                    / weight
            };
            let mean = sum(&|v| v);
            let variance = sum(&|v| (v - mean) * (v - mean));
            (mean, libm::sqrt(variance))
        };
        let own: [_; 3] = core::array::from_fn(|c| moments(&|pair| pair.from, c));
        let other: [_; 3] = core::array::from_fn(|c| moments(&|pair| pair.to, c));
        Overlap {
            first,
            second,
            first_mean: own.map(|m| m.0),
            first_deviation: own.map(|m| m.1),
            second_mean: other.map(|m| m.0),
            second_deviation: other.map(|m| m.1),
            weight,
        }
    }
}

/// A picture's part: display values times `gain` plus `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Factor of red, green and blue.
    pub gain: [f64; 3],
    /// Added to red, green and blue.
    pub offset: [f64; 3],
}

impl Balance {
    /// Nothing is changed.
    pub const NONE: Self = Self {
        gain: [1.0; 3],
        offset: [0.0; 3],
    };
}

/// Why nothing is balanced.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BalanceError {
    /// More pictures than are solved at once.
    #[error("expected at most {most} pictures, found {found}")]
    TooMany {
        /// The limit.
        most: usize,
        /// How many there are.
        found: usize,
    },
    /// An overlap names a picture that is not there, the same one twice, or holds senseless numbers.
    #[error(
        "expected an overlap of two of {pictures} pictures with numbers above 0, found {found}"
    )]
    Overlap {
        /// How many there are.
        pictures: usize,
        /// The overlap.
        found: String,
    },
}

/// Most pictures: their equations fill a matrix of twice as many rows.
pub const MOST_PICTURES: usize = 256;

/// How much all pictures want to stay as they are, against all places that they have in common.
///
/// Small enough that a place too few does not show, large enough that pictures without any overlap stay.
const STAY: f64 = 1e-6;

/// Gains and offsets of `pictures` pictures, so that means and standard deviations agree in all overlaps
/// at once in the least squares; `held` (if any) keeps its own look. Without a held picture the common look
/// is the mean one.
///
/// Normal equations by Cholesky's method in f64, a channel at a time: for each overlap
/// g₁μ₁ + o₁ = g₂μ₂ + o₂ and g₁σ₁ = g₂σ₂, weighted by its places; for each picture g = 1 and o = 0 with a small
/// weight, and for all together Σ g = n, Σ o = 0, since gains of 0 would agree best of all.
///
/// # Errors
/// [`BalanceError`].
pub fn balance(
    pictures: usize,
    overlaps: &[Overlap],
    held: Option<usize>,
) -> Result<Vec<Balance>, BalanceError> {
    if pictures > MOST_PICTURES {
        return Err(BalanceError::TooMany {
            most: MOST_PICTURES,
            found: pictures,
        });
    }
    let senseless = |o: &&Overlap| {
        let numbers = [
            o.first_mean,
            o.first_deviation,
            o.second_mean,
            o.second_deviation,
        ];
        o.first >= pictures
            || o.second >= pictures
            || o.first == o.second
            || o.weight.is_nan()
            || o.weight <= 0.0
            || !numbers.as_flattened().iter().all(|v| v.is_finite())
    };
    if let Some(wrong) = overlaps.iter().find(senseless) {
        return Err(BalanceError::Overlap {
            pictures,
            found: format!("{wrong:?}"),
        });
    }
    let mut balances = vec![Balance::NONE; pictures];
    for channel in 0..3 {
        let solved = channel_balance(pictures, overlaps, held, channel);
        for (balance, [gain, offset]) in balances.iter_mut().zip(solved) {
            (balance.gain[channel], balance.offset[channel]) = (gain, offset);
        }
    }
    Ok(balances)
}

/// Gain and offset of each picture in a channel. Unknowns are differences from the identity.
fn channel_balance(
    pictures: usize,
    overlaps: &[Overlap],
    held: Option<usize>,
    channel: usize,
) -> Vec<[f64; 2]> {
    let total: f64 = overlaps.iter().map(|o| o.weight).sum::<f64>().max(1.0);
    let mut equations = Equations::new(2 * pictures);
    for o in overlaps {
        let weight = o.weight / total;
        let (a, b) = (2 * o.first, 2 * o.second);
        let (ma, mb) = (o.first_mean[channel], o.second_mean[channel]);
        let (sa, sb) = (o.first_deviation[channel], o.second_deviation[channel]);
        equations.add(
            &[(a, ma), (a + 1, 1.0), (b, -mb), (b + 1, -1.0)],
            mb - ma,
            weight,
        );
        equations.add(&[(a, sa), (b, -sb)], sb - sa, weight);
    }
    for picture in 0..pictures {
        let stay = if held == Some(picture) {
            1e6
        } else {
            STAY / pictures.max(1) as f64
        };
        equations.add(&[(2 * picture, 1.0)], 0.0, stay);
        equations.add(&[(2 * picture + 1, 1.0)], 0.0, stay);
    }
    if held.is_none() {
        for part in 0..2 {
            let all: Vec<(usize, f64)> = (0..pictures).map(|p| (2 * p + part, 1.0)).collect();
            equations.add(&all, 0.0, 1.0);
        }
    }
    let solution = equations.solve();
    solution
        .chunks_exact(2)
        .map(|pair| [1.0 + pair[0], pair[1]])
        .collect()
}

/// Equations of least squares, gathered: symmetric, positive definite once every unknown has a wish.
struct Equations {
    size: usize,
    matrix: Vec<f64>,
    right: Vec<f64>,
}

impl Equations {
    fn new(size: usize) -> Self {
        Self {
            size,
            matrix: vec![0.0; size * size],
            right: vec![0.0; size],
        }
    }

    /// Adds Σ factor · unknown = value with a weight.
    fn add(&mut self, terms: &[(usize, f64)], value: f64, weight: f64) {
        for (i, a) in terms {
            self.right[*i] += weight * a * value;
            for (j, b) in terms {
                self.matrix[i * self.size + j] += weight * a * b;
            }
        }
    }

    /// The unknowns.
    fn solve(mut self) -> Vec<f64> {
        let n = self.size;
        for j in 0..n {
            for i in j..n {
                let known: f64 = (0..j)
                    .map(|k| self.matrix[i * n + k] * self.matrix[j * n + k])
                    .sum();
                let left = self.matrix[i * n + j] - known;
                self.matrix[i * n + j] = if i == j {
                    left.max(f64::MIN_POSITIVE).sqrt()
                } else {
                    left / self.matrix[j * n + j]
                };
            }
        }
        for i in 0..n {
            let known: f64 = (0..i).map(|k| self.matrix[i * n + k] * self.right[k]).sum();
            self.right[i] = (self.right[i] - known) / self.matrix[i * n + i];
        }
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n)
                .map(|k| self.matrix[k * n + i] * self.right[k])
                .sum();
            self.right[i] = (self.right[i] - known) / self.matrix[i * n + i];
        }
        self.right
    }
}

#[cfg(test)]
mod tests {
    use core::convert::identity;

    use super::*;

    /// Three pictures of one ground in a row, each seen through its own gain and offset.
    fn row() -> Vec<Overlap> {
        let cameras = [(1.0, 0.0), (0.8, 0.1), (1.2, -0.05)];
        let seen = |picture: usize, mean: f64, deviation: f64| {
            let (gain, offset): (f64, f64) = cameras[picture];
            ([gain * mean + offset; 3], [gain * deviation; 3])
        };
        [(0, 1, 0.3, 0.1), (1, 2, 0.5, 0.15)]
            .map(|(first, second, mean, deviation)| {
                let (first_mean, first_deviation) = seen(first, mean, deviation);
                let (second_mean, second_deviation) = seen(second, mean, deviation);
                Overlap {
                    first,
                    second,
                    first_mean,
                    first_deviation,
                    second_mean,
                    second_deviation,
                    weight: 1000.0,
                }
            })
            .to_vec()
    }

    #[test]
    fn pictures_in_a_row_all_come_to_look_like_the_held_one() {
        let found = balance(3, &row(), Some(0)).unwrap();
        for (balance, (gain, offset)) in found.iter().zip([(1.0, 0.0), (0.8, 0.1), (1.2, -0.05)]) {
            // Undoes the camera.
            assert!((balance.gain[1] * gain - 1.0).abs() < 0.02, "{found:?}");
            assert!(
                (balance.gain[1] * offset + balance.offset[1]).abs() < 0.01,
                "{found:?}"
            );
        }
    }

    #[test]
    fn without_a_held_picture_the_look_is_the_mean_one_and_all_agree() {
        let found = balance(3, &row(), None).unwrap();
        let mean = found.iter().map(|b| b.gain[0]).sum::<f64>() / 3.0;
        assert!((mean - 1.0).abs() < 1e-2, "{mean}");
        for o in row() {
            let shown = |p: usize, mean: [f64; 3]| found[p].gain[0] * mean[0] + found[p].offset[0];
            assert!((shown(o.first, o.first_mean) - shown(o.second, o.second_mean)).abs() < 5e-3);
        }
    }

    #[test]
    fn pictures_that_overlap_nothing_stay() {
        let found = balance(5, &row(), Some(1)).unwrap();
        for alone in &found[3..] {
            assert!((alone.gain[0] - 1.0).abs() < 1e-9 && alone.offset[0].abs() < 1e-9);
        }
        assert_eq!(balance(0, &[], None), Ok(Vec::new()));
    }

    #[test]
    fn pictures_with_clouds_come_to_agree_on_the_ground_that_they_share() {
        let ground: Vec<[f32; 3]> = (0..900)
            .map(|i| {
                let (x, y) = ((i % 30) as f32 / 30.0, (i / 30) as f32 / 30.0);
                [0.2 + 0.4 * x, 0.3 + 0.3 * y, 0.25 + 0.2 * x * y]
            })
            .collect();
        let second = |i: usize, rgb: [f32; 3]| {
            if i.is_multiple_of(5) {
                [0.95; 3]
            } else {
                [rgb[0] * 0.8 + 0.1, rgb[1] * 0.9, rgb[2] * 1.1 + 0.02]
            }
        };
        let pairs: Vec<ColourPair> = ground
            .iter()
            .enumerate()
            .map(|(i, rgb)| ColourPair {
                from: *rgb,
                to: second(i, *rgb),
            })
            .collect();
        let ground = CommonGround::of(&pairs).unwrap();
        let overlap = ground.overlap(0, 1);
        assert!((overlap.weight - 720.0).abs() < 10.0, "{}", overlap.weight);
        let found = balance(2, &[overlap], Some(0)).unwrap();
        let balanced = |i: usize| {
            let Balance { gain, offset } = found[i];
            move |rgb: [f32; 3]| {
                core::array::from_fn(|c| (f64::from(rgb[c]) * gain[c] + offset[c]) as f32)
            }
        };
        let before = ground.difference(identity, identity);
        let after = ground.difference(balanced(0), balanced(1));
        assert!(before.mean_of_same > 5.0, "{before:?}");
        assert!(after.mean_of_same < 0.5, "{after:?}");
        assert!(CommonGround::of(&pairs[..20]).is_err());
    }

    #[test]
    fn senseless_overlaps_are_refused() {
        let mut same = row();
        same[0].second = 0;
        assert!(matches!(
            balance(3, &same, None),
            Err(BalanceError::Overlap { .. })
        ));
        let mut odd = row();
        odd[1].weight = f64::NAN;
        assert!(matches!(
            balance(3, &odd, None),
            Err(BalanceError::Overlap { .. })
        ));
        assert!(matches!(
            balance(300, &[], None),
            Err(BalanceError::TooMany { .. })
        ));
    }
}
