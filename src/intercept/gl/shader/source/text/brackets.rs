//! Brackets among the words of a shader.

/// Returns the index after the bracket that closes the one at `open`.
pub fn behind(words: &[&str], open: usize) -> Option<usize> {
    let (opens, closes) = match *words.get(open)? {
        "(" => ("(", ")"),
        "{" => ("{", "}"),
        "[" => ("[", "]"),
        _ => return None,
    };
    let mut depth = 0;
    for (offset, word) in words[open..].iter().enumerate() {
        if *word == opens {
            depth += 1;
        } else if *word == closes {
            depth -= 1;
            if depth == 0 {
                return Some(open + offset + 1);
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::behind;

    #[test]
    fn the_bracket_that_closes_is_of_the_same_kind_and_depth() {
        let words = ["f", "(", "a", "[", "(", ")", "]", ")", ";"];
        assert_eq!([1, 3, 4].map(|open| behind(&words, open)), [Some(8), Some(7), Some(6)]);
        assert_eq!([0, 5, 9].map(|open| behind(&words, open)), [None; 3], "no bracket opens there");
        assert_eq!(behind(&words[..7], 1), None, "nothing closes it");
    }
}
