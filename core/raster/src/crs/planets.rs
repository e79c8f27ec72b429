//! Radii of planets and moons by ESRI code.
//!
//! Source: the ESRI systems of bodies other than the Earth in PROJ 9's database.

/// A body with its code, name, equatorial radius in metres and inverse flattening (0: a sphere).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Body {
    /// The number in `ESRI:n`.
    pub(crate) code: u32,
    /// Name of the body.
    pub(crate) name: &'static str,
    /// Equatorial radius in metres.
    pub(crate) a_m: f64,
    /// Inverse flattening, 0 for a sphere.
    pub(crate) inverse_flattening: f64,
}

impl Body {
    /// Polar radius in metres.
    pub(crate) fn b_m(&self) -> f64 {
        if self.inverse_flattening == 0.0 {
            self.a_m
        } else {
            self.a_m * (1.0 - 1.0 / self.inverse_flattening)
        }
    }
}

/// The body of a code.
pub(crate) fn by_code(code: u32) -> Option<&'static Body> {
    BODIES.iter().find(|body| body.code == code)
}

/// The body with these radii in metres, to a millionth; of several, one whose name the hint (a
/// citation, say) contains, else the first. `None` where no planet or moon matches.
pub(crate) fn by_radii(a_m: f64, b_m: f64, hint: &str) -> Option<&'static Body> {
    let near = |x: f64, y: f64| (x - y).abs() <= 1e-6 * y;
    let matches = || {
        BODIES
            .iter()
            .filter(|body| near(a_m, body.a_m) && near(b_m, body.b_m()))
    };
    let hint = hint.to_ascii_lowercase();
    matches()
        .find(|body| hint.contains(&body.name.to_ascii_lowercase()))
        .or_else(|| matches().next())
}

const fn body(code: u32, name: &'static str, a_m: f64, inverse_flattening: f64) -> Body {
    Body {
        code,
        name,
        a_m,
        inverse_flattening,
    }
}

/// All bodies, by code.
#[rustfmt::skip]
#[allow(clippy::unreadable_literal, reason = "a table of published constants")]
static BODIES: &[Body] = &[
    body(104872, "Phobos", 11080.0, 0.0),
    body(104873, "Callisto", 2410300.0, 0.0),
    body(104874, "Europa", 1560800.0, 0.0),
    body(104875, "Ganymede", 2631200.0, 0.0),
    body(104876, "Io", 1821490.0, 0.0),
    body(104877, "Metis", 21500.0, 0.0),
    body(104878, "Aegaeon", 330.0, 0.0),
    body(104879, "Anthe", 500.0, 0.0),
    body(104897, "Pandora", 40600.0, 0.0),
    body(104898, "Phoebe", 106500.0, 0.0),
    body(104899, "Polydeuces", 1300.0, 0.0),
    body(104900, "Mercury", 2439700.0, 0.0),
    body(104901, "Venus", 6051000.0, 0.0),
    body(104902, "Venus", 6051800.0, 0.0),
    body(104903, "Moon", 1737400.0, 0.0),
    body(104904, "Mars", 3393400.0, 192.0430107526882),
    body(104905, "Mars", 3396190.0, 169.8944472236118),
    body(104906, "Deimos", 6200.0, 0.0),
    body(104907, "Phobos", 11100.0, 0.0),
    body(104908, "Jupiter", 71492000.0, 15.41440275981026),
    body(104909, "Adrastea", 8200.0, 0.0),
    body(104910, "Amalthea", 83500.0, 0.0),
    body(104911, "Ananke", 10000.0, 0.0),
    body(104912, "Callisto", 2409300.0, 0.0),
    body(104913, "Carme", 15000.0, 0.0),
    body(104914, "Elara", 40000.0, 0.0),
    body(104915, "Europa", 1562090.0, 0.0),
    body(104916, "Ganymede", 2632345.0, 0.0),
    body(104917, "Himalia", 85000.0, 0.0),
    body(104918, "Io", 1821460.0, 0.0),
    body(104919, "Leda", 5000.0, 0.0),
    body(104920, "Lysithea", 12000.0, 0.0),
    body(104921, "Metis", 30000.0, 3.0),
    body(104922, "Pasiphae", 18000.0, 0.0),
    body(104923, "Sinope", 14000.0, 0.0),
    body(104924, "Thebe", 49300.0, 0.0),
    body(104925, "Saturn", 60268000.0, 10.2079945799458),
    body(104926, "Atlas", 16000.0, 0.0),
    body(104927, "Calypso", 9500.0, 0.0),
    body(104928, "Dione", 560000.0, 0.0),
    body(104929, "Enceladus", 249400.0, 0.0),
    body(104930, "Epimetheus", 59500.0, 0.0),
    body(104931, "Helene", 16000.0, 0.0),
    body(104932, "Hyperion", 133000.0, 0.0),
    body(104933, "Iapetus", 718000.0, 0.0),
    body(104934, "Janus", 88800.0, 0.0),
    body(104935, "Mimas", 198630.0, 0.0),
    body(104936, "Pan", 10000.0, 0.0),
    body(104937, "Pandora", 41900.0, 0.0),
    body(104938, "Phoebe", 110000.0, 0.0),
    body(104939, "Prometheus", 50100.0, 0.0),
    body(104940, "Rhea", 764000.0, 0.0),
    body(104941, "Telesto", 11000.0, 0.0),
    body(104942, "Tethys", 529800.0, 0.0),
    body(104943, "Titan", 2575000.0, 0.0),
    body(104944, "Uranus", 25559000.0, 43.61604095563141),
    body(104945, "Ariel", 578900.0, 0.0),
    body(104946, "Belinda", 33000.0, 0.0),
    body(104947, "Bianca", 21000.0, 0.0),
    body(104948, "Cordelia", 13000.0, 0.0),
    body(104949, "Cressida", 31000.0, 0.0),
    body(104950, "Desdemona", 27000.0, 0.0),
    body(104951, "Juliet", 42000.0, 0.0),
    body(104952, "Miranda", 235800.0, 0.0),
    body(104953, "Oberon", 761400.0, 0.0),
    body(104954, "Ophelia", 15000.0, 0.0),
    body(104955, "Portia", 54000.0, 0.0),
    body(104956, "Puck", 77000.0, 0.0),
    body(104957, "Rosalind", 27000.0, 0.0),
    body(104958, "Titania", 788900.0, 0.0),
    body(104959, "Umbriel", 584700.0, 0.0),
    body(104960, "Neptune", 24764000.0, 58.54373522458629),
    body(104961, "Despina", 74000.0, 0.0),
    body(104962, "Galatea", 79000.0, 0.0),
    body(104963, "Larissa", 104000.0, 6.933333333333334),
    body(104964, "Naiad", 29000.0, 0.0),
    body(104965, "Nereid", 170000.0, 0.0),
    body(104966, "Proteus", 208000.0, 0.0),
    body(104967, "Thalassa", 40000.0, 0.0),
    body(104968, "Triton", 1352600.0, 0.0),
    body(104969, "Pluto", 1195000.0, 0.0),
    body(104970, "Charon", 593000.0, 0.0),
    body(104971, "Mars", 3396190.0, 0.0),
    body(104972, "Ceres", 470000.0, 0.0),
    body(104973, "Vesta", 255000.0, 0.0),
    body(104974, "Mercury", 2439400.0, 0.0),
    body(104975, "Sun", 695700000.0, 0.0),
    body(104976, "Atlas", 15100.0, 0.0),
    body(104977, "Calypso", 9600.0, 0.0),
    body(104978, "Daphnis", 3800.0, 0.0),
    body(104979, "Dione", 561400.0, 0.0),
    body(104980, "Enceladus", 252100.0, 0.0),
    body(104981, "Epimetheus", 58200.0, 0.0),
    body(104982, "Helene", 18000.0, 0.0),
    body(104983, "Hyperion", 135000.0, 0.0),
    body(104984, "Iapetus", 745700.0, 0.0),
    body(104985, "Janus", 89200.0, 0.0),
    body(104986, "Methone", 1450.0, 0.0),
    body(104987, "Mimas", 198200.0, 0.0),
    body(104988, "Pallene", 2230.0, 0.0),
    body(104989, "Pan", 14000.0, 0.0),
    body(104993, "Prometheus", 43100.0, 0.0),
    body(104994, "Rhea", 763500.0, 0.0),
    body(104995, "Telesto", 12400.0, 0.0),
    body(104996, "Tethys", 531000.0, 0.0),
    body(104997, "Larissa", 96000.0, 0.0),
    body(104998, "Pluto", 1188300.0, 0.0),
    body(104999, "Charon", 606000.0, 0.0),
];
