//! Numbers as text.

/// A position in metres.
pub fn meters([x, y, z]: [f64; 3]) -> String {
    format!("at ({}, {}, {}) m", number(x), number(y), number(z))
}

/// An angle in degrees.
pub fn degrees(radians: f64) -> String {
    format!("{}°", number(radians.to_degrees()))
}

/// A number with at most three decimal places, without trailing zeros.
pub fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}
