//! Change of a vertex program in assembly language: its position goes to a variable, and code at
//! its end re-projects it.

use crate::intercept::gl::shader::assembly::parameters;
use crate::intercept::gl::state::shader::assembly::ParameterMatrix;

/// Number of local parameters that hold the reprojection matrix.
pub const ROWS: u32 = 4;

const HEADER: &str = "!!ARBvp1.0";

/// Code at the end of a program: `geom::reprojection` in this assembly language.
const EPILOGUE: &str = "\
MOV cupola_place, cupola_position.xyww;
MAD cupola_place.w, cupola_rows[3].x, cupola_position.w, cupola_position.z;
DP4 result.position.x, cupola_rows[0], cupola_place;
DP4 result.position.y, cupola_rows[1], cupola_place;
DP4 cupola_place.x, cupola_rows[2], cupola_place;
MAD cupola_place.y, -cupola_rows[3].x, cupola_place.x, cupola_place.w;
MUL cupola_place.y, cupola_rows[3].y, cupola_place.y;
MAD cupola_place.y, cupola_rows[3].z, cupola_place.x, cupola_place.y;
SGE cupola_equal.x, cupola_position.z, cupola_position.w;
SGE cupola_equal.y, cupola_position.w, cupola_position.z;
MUL cupola_equal.x, cupola_equal.x, cupola_equal.y;
ADD cupola_equal.y, cupola_place.x, -cupola_place.y;
MAD result.position.z, cupola_equal.x, cupola_equal.y, cupola_place.y;
MOV result.position.w, cupola_place.x;
";

/// Returns the changed `source`, and the parameters that may be its matrix. The local parameters
/// from `first_local` on get the reprojection matrix. `None`: the program uses the fixed-function
/// matrices, or is not understood.
pub fn patch(source: &str, first_local: u32) -> Option<(String, Vec<ParameterMatrix>)> {
    let bare = without_comments(source);
    let body = bare.trim_start().strip_prefix(HEADER)?;
    let variants = ["ARB_position_invariant", "OPTION NV", "cupola_"];
    if !source.is_ascii() || variants.iter().any(|word| body.contains(word)) || uses_from(body, first_local) {
        return None;
    }
    let found = parameters::of_position(&bare);
    if found.others {
        return None;
    }
    // Options must come before all statements.
    let options = body.rfind("OPTION").map_or(Some(0), |at| body[at..].find(';').map(|end| at + end + 1))?;
    let (options, rest) = body.split_at(options);
    let mut changed = String::with_capacity(source.len() + 1024);
    let mut writes = false;
    let end = rest.rfind("END").filter(|end| rest[end + 3..].trim().is_empty())?;
    for statement in rest[..end].split_inclusive(';') {
        let word = statement.trim_start();
        let is_position = word.contains("result.position");
        writes |= is_position;
        match word.strip_prefix("OUTPUT").filter(|_| is_position) {
            Some(rest) => changed.extend(["\nALIAS", &rest.replace("result.position", "cupola_position")]),
            None => changed.push_str(&statement.replace("result.position", "cupola_position")),
        }
    }
    let last = first_local + ROWS - 1;
    let declared = format!(
        "TEMP cupola_position, cupola_place, cupola_equal;\nPARAM cupola_rows[4] = {{ program.local[{first_local}..{last}] }};\n"
    );
    writes.then(|| (format!("{HEADER}{options}\n{declared}{changed}\n{EPILOGUE}END\n"), found.matrices()))
}

/// True if the program uses a local parameter from `first` on.
fn uses_from(body: &str, first: u32) -> bool {
    let numbers = |place: &str| -> Vec<u32> {
        let inner = place.trim_start().strip_prefix('[').and_then(|inner| inner.split(']').next());
        inner.into_iter().flat_map(|inner| inner.split("..")).filter_map(|number| number.trim().parse().ok()).collect()
    };
    body.split("program.local").skip(1).any(|place| numbers(place).into_iter().any(|number| number >= first))
}

/// Removes comments, which go from `#` to the end of the line.
fn without_comments(source: &str) -> String {
    source.split_inclusive(['\n', '\r']).fold(String::with_capacity(source.len()), |mut bare, line| {
        let code = line.split('#').next().unwrap_or_default();
        bare.push_str(code);
        if code.len() < line.len() {
            bare.push('\n');
        }
        bare
    })
}

#[cfg(test)]
mod tests {
    use super::patch;

    #[test]
    fn the_position_goes_to_a_variable() {
        let source = "!!ARBvp1.0\nOPTION ARB_fog_linear;\n# result.position\nOUTPUT p = result.position;\n\
                      MOV p, program.env[0];\nMOV result.position.w, program.local[3];\nEND\n";
        let (changed, _) = patch(source, 92).expect("understood");
        let statements: Vec<&str> = changed.lines().collect();
        assert_eq!(statements[..2], ["!!ARBvp1.0", "OPTION ARB_fog_linear;"]);
        assert!(changed.contains("ALIAS p = cupola_position;\nMOV p, program.env[0];"), "{changed}");
        assert!(changed.contains("MOV cupola_position.w, program.local[3];"));
        assert!(
            changed.contains("program.local[92..95]")
                && changed.ends_with("MOV result.position.w, cupola_place.x;\nEND\n")
        );
        assert!(!changed.contains('#') && !changed.contains("OUTPUT"));
    }

    #[test]
    fn other_programs_are_left_alone() {
        for source in [
            "",
            "!!ARBfp1.0\nMOV result.color, fragment.color;\nEND",
            "!!ARBvp1.0\nOPTION ARB_position_invariant;\nMOV result.color, vertex.color;\nEND",
            "!!ARBvp1.0\nPARAM m[4] = { state.matrix.mvp };\nDP4 result.position.x, m[0], vertex.position;\nEND",
            "!!ARBvp1.0\nMOV result.color, vertex.color;\nEND",
            "!!ARBvp1.0\nMOV result.position, program.local[93];\nEND",
            "!!ARBvp1.0\nMOV result.position, program.local[ 0..92 ];\nEND",
            "!!ARBvp1.0\nMOV result.position, vertex.position;\n",
            "!!ARBvp1.0\nMOV result.position, vertex.position;\nEND more",
        ] {
            assert_eq!(patch(source, 92), None, "{source}");
        }
    }
}
