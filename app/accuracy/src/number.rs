//! Numbers as people read them.

/// Significant digits of a measured number.
const DIGITS: i32 = 3;

/// A number with three significant digits: `12.3`, `4.56·10⁻⁷`, `0`, `not finite`.
pub fn text(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return "not finite".to_owned();
    }
    let rounded = format!("{value:.*e}", DIGITS as usize - 1);
    let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if !(-3..6).contains(&exponent) {
        return format!("{}·{}", trimmed(mantissa), power_of_ten(exponent));
    }
    let decimals = (DIGITS - 1 - exponent).max(0) as usize;
    trimmed(&format!("{value:.decimals$}")).to_owned()
}

/// `10⁻⁷`.
pub fn power_of_ten(exponent: i32) -> String {
    const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digits = exponent.unsigned_abs().to_string();
    let raised = digits
        .chars()
        .filter_map(|digit| RAISED.get(digit.to_digit(10)? as usize));
    let sign = if exponent < 0 { "⁻" } else { "" };
    format!("10{sign}{}", raised.collect::<String>())
}

/// Without zeros that say nothing after the point.
fn trimmed(number: &str) -> &str {
    if number.contains('.') {
        number.trim_end_matches('0').trim_end_matches('.')
    } else {
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits_that_say_something() {
        let cases = [
            (0.0, "0"),
            (1.0, "1"),
            (12.345, "12.3"),
            (-0.001_234_5, "-0.00123"),
            (123_456.0, "123456"),
            (4.56e-7, "4.56·10⁻⁷"),
            (2.0e12, "2·10¹²"),
            (999.96, "1000"),
            (f64::NAN, "not finite"),
        ];
        for (value, expected) in cases {
            assert_eq!(text(value), expected);
        }
    }
}
