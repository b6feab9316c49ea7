//! Names of keys: those of X for the symbols on them.

/// Names of keys without a character, and of those whose character cannot stand in a line.
const NAMES: [(&str, u32); 62] = [
    ("space", 0x20),
    ("BackSpace", 0xff08),
    ("Tab", 0xff09),
    ("Return", 0xff0d),
    ("Pause", 0xff13),
    ("Scroll_Lock", 0xff14),
    ("Print", 0xff61),
    ("Escape", 0xff1b),
    ("Home", 0xff50),
    ("Left", 0xff51),
    ("Up", 0xff52),
    ("Right", 0xff53),
    ("Down", 0xff54),
    ("Page_Up", 0xff55),
    ("Page_Down", 0xff56),
    ("End", 0xff57),
    ("Insert", 0xff63),
    ("Menu", 0xff67),
    ("Num_Lock", 0xff7f),
    ("KP_Enter", 0xff8d),
    ("KP_Home", 0xff95),
    ("KP_Left", 0xff96),
    ("KP_Up", 0xff97),
    ("KP_Right", 0xff98),
    ("KP_Down", 0xff99),
    ("KP_Page_Up", 0xff9a),
    ("KP_Page_Down", 0xff9b),
    ("KP_End", 0xff9c),
    ("KP_Begin", 0xff9d),
    ("KP_Insert", 0xff9e),
    ("KP_Delete", 0xff9f),
    ("KP_Multiply", 0xffaa),
    ("KP_Add", 0xffab),
    ("KP_Subtract", 0xffad),
    ("KP_Divide", 0xffaf),
    ("F1", 0xffbe),
    ("F2", 0xffbf),
    ("F3", 0xffc0),
    ("F4", 0xffc1),
    ("F5", 0xffc2),
    ("F6", 0xffc3),
    ("F7", 0xffc4),
    ("F8", 0xffc5),
    ("F9", 0xffc6),
    ("F10", 0xffc7),
    ("F11", 0xffc8),
    ("F12", 0xffc9),
    ("Shift_L", 0xffe1),
    ("Shift_R", 0xffe2),
    ("Control_L", 0xffe3),
    ("Control_R", 0xffe4),
    ("Caps_Lock", 0xffe5),
    ("Meta_L", 0xffe7),
    ("Meta_R", 0xffe8),
    ("Alt_L", 0xffe9),
    ("Alt_R", 0xffea),
    ("Super_L", 0xffeb),
    ("Super_R", 0xffec),
    ("Hyper_L", 0xffed),
    ("Hyper_R", 0xffee),
    ("ISO_Level3_Shift", 0xfe03),
    ("Delete", 0xffff),
];

/// Added to a character's number in Unicode, gives its symbol beyond Latin-1.
const UNICODE: u32 = 0x0100_0000;

/// Returns the symbol of a key from its character, its name or its hexadecimal number.
pub fn symbol(name: &str) -> Option<u32> {
    let mut signs = name.chars();
    if let (Some(sign), None) = (signs.next(), signs.next()) {
        let number = u32::from(sign);
        return Some(if number < 0x100 { number } else { UNICODE + number });
    }
    let known = NAMES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|(_, symbol)| *symbol);
    known.or_else(|| u32::from_str_radix(name.strip_prefix("0x")?, 16).ok().filter(|symbol| *symbol > 0))
}

/// Returns the name of a key, as [`symbol`] accepts it.
pub fn name(symbol: u32) -> String {
    if let Some((name, _)) = NAMES.iter().find(|(_, known)| *known == symbol) {
        return (*name).to_owned();
    }
    let number = if symbol < 0x100 { symbol } else { symbol.wrapping_sub(UNICODE) };
    let sign = char::from_u32(number).filter(|sign| !sign.is_control() && !sign.is_whitespace());
    sign.map_or_else(|| format!("{symbol:#x}"), String::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back_to_their_keys() {
        for wanted in NAMES.map(|(_, symbol)| symbol).into_iter().chain([0x61, 0x23, 0xe4, 0x0100_20ac, 0xfe52, 0xff80])
        {
            assert_eq!(symbol(&name(wanted)), Some(wanted), "{wanted:#x} {}", name(wanted));
        }
        assert_eq!((symbol("left"), symbol("a"), symbol("0xff51")), (Some(0xff51), Some(0x61), Some(0xff51)));
        assert_eq!([symbol("Lefft"), symbol(""), symbol("0x"), symbol("0x0")], [None; 4]);
    }
}
