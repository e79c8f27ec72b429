//! What is measured, and how exactly.

/// A measured quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Amount {
    /// Its value.
    pub value: f64,
    /// What discretisation may have cost: the true value lies within so much of it as soon as halving
    /// the spacing at least halves the error.
    pub error: f64,
}

/// What a change comes to. Areas and volumes are those on the ellipsoid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Volumes {
    /// Ground taken away in cubic metres, positive.
    pub cut_m3: Amount,
    /// Ground put on in cubic metres, positive.
    pub fill_m3: Amount,
    /// Fill minus cut in cubic metres.
    pub net_m3: Amount,
    /// Area that changes, seen from above, in square metres.
    pub plan_area_m2: Amount,
    /// Area of the surface after, where it changes, in square metres.
    pub surface_area_m2: Amount,
    /// Deepest cut in metres, positive.
    pub highest_cut_m: Amount,
    /// Highest fill in metres.
    pub highest_fill_m: Amount,
    /// Mean angle of the surface after against the horizontal, where it changes, in degrees.
    pub mean_slope_deg: Amount,
    /// Samples that were evaluated.
    pub samples: u64,
    /// Finest spacing of samples in metres.
    pub finest_m: f64,
}

impl Amount {
    fn and(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            error: self.error + other.error,
        }
    }

    /// The larger one, as large as either may be.
    fn or(self, other: Self) -> Self {
        let value = self.value.max(other.value);
        let bound = (self.value + self.error).max(other.value + other.error);
        Self {
            value,
            error: bound - value,
        }
    }
}

impl Volumes {
    /// What two changes of disjoint regions come to together.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let plan_area_m2 = self.plan_area_m2.and(other.plan_area_m2);
        let weighted = |amount: fn(&Self) -> f64| {
            let sum =
                amount(self) * self.plan_area_m2.value + amount(other) * other.plan_area_m2.value;
            if plan_area_m2.value > 0.0 {
                sum / plan_area_m2.value
            } else {
                0.0
            }
        };
        Self {
            cut_m3: self.cut_m3.and(other.cut_m3),
            fill_m3: self.fill_m3.and(other.fill_m3),
            net_m3: self.net_m3.and(other.net_m3),
            plan_area_m2,
            surface_area_m2: self.surface_area_m2.and(other.surface_area_m2),
            highest_cut_m: self.highest_cut_m.or(other.highest_cut_m),
            highest_fill_m: self.highest_fill_m.or(other.highest_fill_m),
            mean_slope_deg: Amount {
                value: weighted(|v| v.mean_slope_deg.value),
                error: weighted(|v| v.mean_slope_deg.error),
            },
            samples: self.samples + other.samples,
            finest_m: if self.samples == 0 {
                other.finest_m
            } else {
                self.finest_m.min(other.finest_m)
            },
        }
    }
}
