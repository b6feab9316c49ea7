//! The words of a shader's text.

use crate::intercept::gl::shader::source::patch;

/// The words of a text, without comments and directives.
pub struct Tokens<'a> {
    /// Names, numbers and operators, in order.
    pub words: Vec<&'a str>,
    /// Names of macros, and their words.
    pub macros: Vec<&'a str>,
}

/// Operators of more than one character, in order of descending length.
const OPERATORS: [&str; 21] = [
    "<<=", ">>=", "==", "!=", "<=", ">=", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "++", "--", "&&", "||", "^^",
    "<<", ">>",
];

/// Words in macros that may be statements, or change the structure of statements.
const KEYWORDS: [&str; 24] = [
    "{",
    "}",
    ";",
    "=",
    "if",
    "else",
    "for",
    "while",
    "do",
    "switch",
    "case",
    "return",
    "attribute",
    "varying",
    "in",
    "out",
    "uniform",
    "const",
    "layout",
    "void",
    "vec2",
    "vec3",
    "vec4",
    "mat4",
];

/// True if a word is a name.
pub fn is_name(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
}

/// Splits a text without comments into words. All branches of conditional compilation are included.
/// `None`: the text has features that are not supported (continued lines, unknown directives, names
/// made by macros).
pub fn split(bare: &str) -> Option<Tokens<'_>> {
    if bare.contains('\\') || !bare.is_ascii() {
        return None;
    }
    let mut tokens = Tokens { words: Vec::new(), macros: Vec::new() };
    for line in bare.lines() {
        match line.trim_start().strip_prefix('#') {
            Some(directive) => tokens.directive(directive.trim_start())?,
            None => words(line, &mut tokens.words),
        }
    }
    Some(tokens)
}

impl<'a> Tokens<'a> {
    fn directive(&mut self, text: &'a str) -> Option<()> {
        let end = text.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(text.len());
        let (name, rest) = text.split_at(end);
        match name {
            "" | "version" | "extension" | "line" | "pragma" | "error" => {}
            "if" | "ifdef" | "ifndef" | "elif" | "else" | "endif" | "undef" => {}
            "define" if !rest.contains("##") => {
                let first = self.macros.len();
                words(rest, &mut self.macros);
                let mut defined = self.macros[first..].iter();
                let dialect = matches!(self.macros[first..], ["attribute", "in"] | ["varying", "in" | "out"]);
                if !dialect && defined.any(|word| KEYWORDS.contains(word)) {
                    return None;
                }
            }
            _ => return None,
        }
        Some(())
    }
}

pub fn words<'a>(line: &'a str, found: &mut Vec<&'a str>) {
    let part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut rest = line.trim_start();
    while let Some(first) = rest.chars().next() {
        let number = first.is_ascii_digit() || (first == '.' && rest[1..].starts_with(|c: char| c.is_ascii_digit()));
        let length = if number {
            number_length(rest)
        } else if part(first) {
            rest.find(|c| !part(c)).unwrap_or(rest.len())
        } else {
            OPERATORS.iter().find(|o| rest.starts_with(**o)).map_or(1, |o| o.len())
        };
        found.push(&rest[..length]);
        rest = rest[length..].trim_start();
    }
}

/// Returns the length of the number at the beginning of `text`: `1`, `1.0f`, `.5`, `1e-3`, `0x1Fu`.
fn number_length(text: &str) -> usize {
    let mut before = ' ';
    text.find(|c: char| {
        let exponent = matches!(before, 'e' | 'E') && matches!(c, '+' | '-') && !text.starts_with("0x");
        before = c;
        !(c.is_ascii_alphanumeric() || c == '.' || exponent)
    })
    .unwrap_or(text.len())
}

/// Returns the value of a number without an exponent; `None` for other words.
pub fn number(word: &str) -> Option<f64> {
    word.trim_end_matches(['f', 'F'])
        .parse()
        .ok()
        .filter(|_| word.starts_with(|c: char| c.is_ascii_digit() || c == '.'))
}

/// Returns a text without its comments, byte for byte.
pub fn bare(source: &str) -> std::borrow::Cow<'_, str> {
    patch::strip_comments(source)
}

#[cfg(test)]
mod tests {
    use super::{number, split};

    #[test]
    fn words_numbers_and_operators_are_told_apart() {
        let tokens = split("a.x+=vec4(1.0f,.5,1e-3)*b[2];c--;").expect("plain");
        assert_eq!(tokens.words.join(" "), "a . x += vec4 ( 1.0f , .5 , 1e-3 ) * b [ 2 ] ; c -- ;");
        assert_eq!(split("x=1.-y").expect("plain").words, ["x", "=", "1.", "-", "y"]);
    }

    #[test]
    fn directives_are_no_words_but_macros_are_noted() {
        let tokens = split("#version 120\n#ifdef A\n# define f(x) g(x)\n#endif\nint i;\n").expect("plain");
        assert_eq!(tokens.words, ["int", "i", ";"]);
        assert!(tokens.macros.contains(&"f") && tokens.macros.contains(&"g"));
        assert!(split("#define attribute in\n").is_some());
        for strange in [
            "#define uniform attribute\n",
            "#define M if (x) {\n",
            "#define M a = b\n",
            "#include \"x\"\n",
            "#define a b##c\n",
            "a = \\\n b;",
            "é",
        ] {
            assert!(split(strange).is_none(), "{strange}");
        }
    }

    #[test]
    fn numbers_have_values() {
        assert_eq!([number("1"), number("1.0f"), number(".5"), number("1.")].map(Option::unwrap), [1.0, 1.0, 0.5, 1.0]);
        assert_eq!([number("x"), number("inf"), number("1e"), number("f")], [None; 4]);
    }
}
