//! Search for the shortest list of calls that still differs.

/// Removes lines as long as `differs` holds for the rest; the first line always stays. The result
/// differs, and no longer does without any one of its other lines, unless `most` trials were too
/// few.
pub fn minimise<E>(
    lines: &[String],
    most: usize,
    mut differs: impl FnMut(&[String]) -> Result<bool, E>,
) -> Result<Vec<String>, E> {
    let mut kept = lines.to_vec();
    let mut trials = 0;
    let mut length = kept.len().div_ceil(2).max(1);
    loop {
        let mut removed = false;
        // Starts at the end, because late lines depend on earlier ones.
        let mut end = kept.len();
        while end > 1 {
            let start = end.saturating_sub(length).max(1);
            let rest: Vec<String> = kept[..start].iter().chain(&kept[end..]).cloned().collect();
            if trials >= most {
                return Ok(kept);
            }
            trials += 1;
            if differs(&rest)? {
                kept = rest;
                removed = true;
            }
            end = start;
        }
        if length == 1 && !removed {
            return Ok(kept);
        }
        if length > 1 {
            length = length.div_ceil(2);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::minimise;

    #[test]
    fn what_is_needed_stays() {
        let lines: Vec<String> = (0..300).map(|number| number.to_string()).collect();
        let needed = ["17", "18", "203"];
        let differs =
            |lines: &[String]| Ok::<_, ()>(needed.iter().all(|wanted| lines.iter().any(|line| line == wanted)));
        assert_eq!(minimise(&lines, 1000, differs).unwrap(), ["0", "17", "18", "203"]);
    }

    #[test]
    fn trials_are_limited() {
        let lines: Vec<String> = (0..100).map(|number| number.to_string()).collect();
        let mut trials = 0;
        let kept = minimise(&lines, 5, |_| {
            trials += 1;
            Ok::<_, ()>(false)
        });
        assert_eq!((kept.unwrap().len(), trials), (100, 5));
    }
}
