//! Finds the lens among a program's 4×4 matrices. No graphics API is named.

use crate::runtime::session::{Intrinsics, MatrixClass, classify};

/// The lens that `matrices` (how much their names promise, values column by column) hold, and how it was found;
/// `None`: what they draw is flat.
pub fn find<'a>(matrices: impl Iterator<Item = (u8, &'a [f64; 16])>) -> Option<(Intrinsics, &'static str)> {
    let mut best: Option<(u8, Intrinsics, &'static str)> = None;
    for (rank, matrix) in matrices {
        let turned = transposed(matrix);
        let (value, pure) = if is_projection(&turned) { (&turned, true) } else { (matrix, is_projection(matrix)) };
        let MatrixClass::Perspective(intrinsics) = classify(value) else { continue };
        let rank = rank * 2 + u8::from(!pure);
        if best.as_ref().is_none_or(|b| rank < b.0) {
            let how = if pure { "projection matrix uniform" } else { "model-view-projection matrix uniform" };
            best = Some((rank, intrinsics, how));
        }
    }
    best.map(|(_, intrinsics, how)| (intrinsics, how))
}

/// `[A 0 B 0; 0 C D 0; 0 0 E F; 0 0 ∓1 0]`, column by column.
fn is_projection(m: &[f64; 16]) -> bool {
    let zero = [1, 2, 3, 4, 6, 7, 12, 13, 15];
    zero.iter().all(|i| m[*i] == 0.0) && m[11].abs() == 1.0
}

/// Rows for columns.
pub fn transposed(m: &[f64; 16]) -> [f64; 16] {
    std::array::from_fn(|i| m[i % 4 * 4 + i / 4])
}

/// How much a name promises to be the projection: 0, 1, 2, the lower the more.
pub fn rank(name: &str) -> u8 {
    let name = name.to_ascii_lowercase();
    let has = |words: &[&str]| words.iter().any(|w| name.contains(w));
    if has(&["shadow", "light", "tex", "bias", "inv", "prev", "last", "normal", "reflect"]) {
        2
    } else if has(&["proj", "mvp", "persp", "camera", "frustum"]) {
        0
    } else {
        1
    }
}

#[cfg(test)]
mod tests {
    use super::{find, is_projection, rank, transposed};

    const PROJECTION: [f64; 16] = [1.5, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.1, 0.2, -1.01, -1.0, 0.0, 0.0, -0.2, 0.0];

    #[test]
    fn a_projection_is_told_from_its_transpose_and_from_a_translation() {
        assert!(is_projection(&PROJECTION));
        assert!(!is_projection(&transposed(&PROJECTION)));
        let translation = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0, 1.0];
        assert!(!is_projection(&translation));
        assert!(!is_projection(&transposed(&translation)));
    }

    #[test]
    fn names_promise() {
        assert!(rank("u_projectionMatrix") < rank("matrix"));
        assert!(rank("matrix") < rank("shadowProjection"));
    }

    #[test]
    fn the_purest_and_most_promising_matrix_is_believed() {
        let mut wider = PROJECTION;
        wider[0] = 0.7;
        let lens = |list: &[(u8, &[f64; 16])]| find(list.iter().copied()).map(|(lens, _)| lens.a);
        assert_eq!(lens(&[(1, &PROJECTION), (0, &wider)]), Some(0.7));
        assert_eq!(lens(&[(1, &transposed(&PROJECTION)), (1, &wider)]), Some(1.5));
        assert_eq!(lens(&[]), None);
    }
}
