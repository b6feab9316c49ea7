//! Numbers on the command line.

/// Parses a number, with a decimal point.
pub fn number(text: &str) -> Result<f64, String> {
    text.trim().parse::<f64>().ok().filter(|number| number.is_finite()).ok_or_else(|| {
        let hint = if text.contains(',') { "; the decimal sign is a point" } else { "" };
        format!("expected a number without a unit, for example 8.5{hint}")
    })
}
