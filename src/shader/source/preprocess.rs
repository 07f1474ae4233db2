//! Directives followed: conditionals, macros and includes, the import directives of WGSL's preprocessors set aside.

use super::condition;
use super::error::SourceError;
use super::lexer::{File, Kind, Origin, Token, lex};
use super::macros::{Macro, Macros};
use super::{Environment, Language};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// How deep files may include each other.
const MOST_DEPTH: usize = 32;
/// The files and the bytes that one source may include.
const MOST_FILES: usize = 2000;
const MOST_BYTES: usize = 64 << 20;

/// A file without directives.
#[derive(Debug, Default)]
pub(super) struct Preprocessed {
    pub(super) tokens: Vec<Token>,
    /// The tokens after each `#import`.
    pub(super) imports: Vec<Vec<Token>>,
    /// The segments of `#define_import_path`.
    pub(super) path: Vec<Rc<str>>,
}

/// One `#if` that is open.
struct Conditional {
    origin: Origin,
    /// The lines here count.
    active: bool,
    /// A branch has been taken, or none may be.
    taken: bool,
    is_last: bool,
}

/// Adds a file and returns its number.
pub(super) fn add(
    files: &mut Vec<File>,
    name: &str,
    text: &str,
    directory: Option<PathBuf>,
) -> Result<usize, SourceError> {
    let bytes = files.iter().fold(text.len(), |sum, file| sum.saturating_add(file.text.len()));
    if files.len() >= MOST_FILES || bytes > MOST_BYTES {
        let message = format!("more than {MOST_FILES} files or {} MB are included", MOST_BYTES >> 20);
        return Err(SourceError::of(name, message));
    }
    files.push(File { name: name.to_owned(), text: without_script(text), directory });
    Ok(files.len() - 1)
}

/// A shader that stands in a JavaScript module as a template, without what is around it: blanks take its place.
fn without_script(text: &str) -> String {
    let head = text.trim_start();
    let is_script = ["export ", "import ", "const ", "// "].iter().any(|start| head.starts_with(start));
    let before = text.split('`').next().unwrap_or_default();
    if !is_script || !before.contains("export ") || text.matches('`').count() < 2 || before.contains('{') {
        return text.to_owned();
    }
    let blank = |part: &str| -> String { part.chars().map(|c| if c == '\n' { '\n' } else { ' ' }).collect() };
    let mut parts = text.splitn(3, '`');
    let mut next = || parts.next().unwrap_or_default();
    let (head, body, tail) = (next(), next(), next());
    format!("{} {body} {}", blank(head), blank(tail))
}

/// Follows the directives of a file.
pub(super) fn preprocess(
    files: &mut Vec<File>,
    index: usize,
    language: Language,
    environment: &Environment,
    macros: &mut Macros,
) -> Result<Preprocessed, SourceError> {
    let mut preprocessor =
        Preprocessor { files, language, environment, macros, conditionals: Vec::new(), done: Preprocessed::default() };
    preprocessor.file(index, 0)?;
    Ok(preprocessor.done)
}

struct Preprocessor<'a> {
    files: &'a mut Vec<File>,
    language: Language,
    environment: &'a Environment,
    macros: &'a mut Macros,
    conditionals: Vec<Conditional>,
    done: Preprocessed,
}

impl Preprocessor<'_> {
    fn file(&mut self, index: usize, depth: usize) -> Result<(), SourceError> {
        let tokens = lex(self.files, index, self.language)?;
        let outer = self.conditionals.len();
        let mut pending: Vec<Token> = Vec::new();
        let mut at = 0;
        while let Some(token) = tokens.get(at) {
            let mut end = at + 1;
            while tokens.get(end).is_some_and(|token| !token.leads) {
                end += 1;
            }
            let line = tokens.get(at..end).unwrap_or_default();
            let is_directive = token.is("#") && line.get(1).is_none_or(|next| !next.is("{"));
            if is_directive {
                if self.is_active() {
                    self.flush(&mut pending)?;
                }
                // naga_oil's braces may hold their imports over several lines.
                if line.get(1).is_some_and(|word| word.is("import")) {
                    end = closed(&tokens, at, end);
                }
                let line = tokens.get(at + 1..end).unwrap_or_default();
                self.directive(token, line, index, depth)?;
            } else if self.is_active() {
                pending.extend_from_slice(line);
            }
            at = end;
        }
        self.flush(&mut pending)?;
        if let Some(open) = self.conditionals.get(outer..).and_then(<[Conditional]>::first) {
            return Err(self.error(open.origin, "this condition has no #endif"));
        }
        Ok(())
    }

    fn is_active(&self) -> bool {
        self.conditionals.iter().all(|conditional| conditional.active)
    }

    fn error(&self, origin: Origin, message: impl Into<String>) -> SourceError {
        SourceError::at(self.files, origin, message)
    }

    fn flush(&mut self, pending: &mut Vec<Token>) -> Result<(), SourceError> {
        let tokens = self.spliced(std::mem::take(pending))?;
        let expanded = self.macros.expand(tokens, self.files)?;
        self.done.tokens.extend(expanded);
        Ok(())
    }

    /// naga_oil's `#{NAME}` replaced by what the name stands for.
    fn spliced(&self, tokens: Vec<Token>) -> Result<Vec<Token>, SourceError> {
        if self.language != Language::Wgsl || !tokens.iter().any(|token| token.is("#")) {
            return Ok(tokens);
        }
        let mut output = Vec::with_capacity(tokens.len());
        let mut at = 0;
        while let Some(token) = tokens.get(at) {
            let part = |offset: usize| tokens.get(at + offset);
            let braced = part(1).is_some_and(|open| open.is("{")) && part(3).is_some_and(|close| close.is("}"));
            let name = if braced { part(2) } else { part(1) };
            match name {
                Some(name) if token.is("#") => {
                    let Some(found) = self.macros.get(&name.text) else {
                        let message = format!("`{}` is not defined; give it with -D {0}=VALUE", name.text);
                        return Err(self.error(name.origin, message));
                    };
                    output.extend(found.body.iter().map(|part| Token { origin: token.origin, ..part.clone() }));
                    at += if braced { 4 } else { 2 };
                }
                _ => {
                    output.push(token.clone());
                    at += 1;
                }
            }
        }
        Ok(output)
    }

    fn directive(&mut self, hash: &Token, line: &[Token], index: usize, depth: usize) -> Result<(), SourceError> {
        let Some((name, rest)) = line.split_first() else { return Ok(()) };
        match &*name.text {
            "if" | "ifdef" | "ifndef" => {
                let active = self.is_active();
                let holds = active && self.holds(name, rest)?;
                let conditional =
                    Conditional { origin: hash.origin, active: holds, taken: holds || !active, is_last: false };
                self.conditionals.push(conditional);
                return Ok(());
            }
            "elif" | "else" => {
                // `#else ifdef X` and `#else if X` are naga_oil's `#elif`.
                let chained = rest.first().filter(|word| matches!(&*word.text, "if" | "ifdef" | "ifndef"));
                let is_plain = &*name.text == "else" && (chained.is_none() || self.language == Language::Glsl);
                let taken = match self.conditionals.last() {
                    None => return Err(self.error(hash.origin, format!("#{} without #if", name.text))),
                    Some(last) if last.is_last => {
                        return Err(self.error(hash.origin, format!("#{} after #else", name.text)));
                    }
                    Some(last) => last.taken,
                };
                let holds = !taken
                    && match (is_plain, chained) {
                        (true, _) => true,
                        (false, Some(word)) => self.holds(word, rest.get(1..).unwrap_or_default())?,
                        (false, None) => self.holds(name, rest)?,
                    };
                if let Some(last) = self.conditionals.last_mut() {
                    (last.active, last.taken, last.is_last) = (holds, taken || holds, is_plain);
                }
                return Ok(());
            }
            "endif" => {
                return match self.conditionals.pop() {
                    Some(_) => Ok(()),
                    None => Err(self.error(hash.origin, "#endif without #if")),
                };
            }
            _ => {}
        }
        if !self.is_active() {
            return Ok(());
        }
        match &*name.text {
            "define" | "undef" => self.define(name, rest),
            "include" => self.include(name, rest, index, depth),
            "import" => {
                self.done.imports.push(rest.to_vec());
                Ok(())
            }
            "define_import_path" => {
                self.done.path = rest.iter().filter(|part| part.is_word()).map(|part| Rc::clone(&part.text)).collect();
                Ok(())
            }
            "error" => {
                let text: Vec<&str> = rest.iter().map(|token| &*token.text).collect();
                Err(self.error(hash.origin, format!("#error {}", text.join(" "))))
            }
            // What these say is for a driver.
            "version" | "extension" | "pragma" | "line" | "endinput" => Ok(()),
            other => Err(self.error(name.origin, format!("the directive `#{other}` is not known"))),
        }
    }

    fn holds(&mut self, keyword: &Token, rest: &[Token]) -> Result<bool, SourceError> {
        if let "ifdef" | "ifndef" = &*keyword.text {
            let Some(name) = rest.first().filter(|name| name.is_word()) else {
                return Err(self.error(keyword.origin, format!("#{} names no macro", keyword.text)));
            };
            return Ok(self.macros.get(&name.text).is_some() == (&*keyword.text == "ifdef"));
        }
        let mut asked = Vec::new();
        let mut at = 0;
        while let Some(token) = rest.get(at) {
            let part = |offset: usize| rest.get(at + offset);
            let named = if part(1).is_some_and(|next| next.is("(")) { 2 } else { 1 };
            match part(named).filter(|name| token.is("defined") && name.is_word()) {
                Some(name) => {
                    let value = if self.macros.get(&name.text).is_some() { "1" } else { "0" };
                    asked.push(Token::instead(value, Kind::Number, name));
                    at += if named == 2 { 4 } else { 2 };
                }
                None => {
                    asked.push(token.clone());
                    at += 1;
                }
            }
        }
        let expanded = self.macros.expand(asked, self.files)?;
        let value = condition::value(&expanded);
        value.map(|value| value != 0).map_err(|what| self.error(keyword.origin, format!("#{}: {what}", keyword.text)))
    }

    fn define(&mut self, keyword: &Token, rest: &[Token]) -> Result<(), SourceError> {
        let Some((name, body)) = rest.split_first().filter(|(name, _)| name.is_word()) else {
            return Err(self.error(keyword.origin, format!("#{} names no macro", keyword.text)));
        };
        if keyword.is("undef") {
            self.macros.undefine(&name.text);
            return Ok(());
        }
        // Parentheses that touch the name hold parameters; others are of the body.
        let Some(open) = body.first().filter(|open| open.is("(") && !open.spaced) else {
            self.macros.define(&name.text, Macro { parameters: None, body: body.to_vec() });
            return Ok(());
        };
        let Some(close) = body.iter().position(|token| token.is(")")) else {
            return Err(self.error(open.origin, "the macro's parameters have no `)`"));
        };
        let mut parameters = Vec::new();
        for (at, token) in body.get(1..close).unwrap_or_default().iter().enumerate() {
            match at % 2 {
                0 if token.is_word() => parameters.push(Rc::clone(&token.text)),
                1 if token.is(",") => {}
                _ => return Err(self.error(token.origin, "a macro's parameters are names with commas between them")),
            }
        }
        let body = body.get(close + 1..).unwrap_or_default().to_vec();
        self.macros.define(&name.text, Macro { parameters: Some(parameters), body });
        Ok(())
    }

    fn include(&mut self, keyword: &Token, rest: &[Token], index: usize, depth: usize) -> Result<(), SourceError> {
        let wanted = match rest.first() {
            Some(quoted) if quoted.kind == Kind::Quoted => quoted.text.to_string(),
            Some(open) if open.is("<") => {
                rest.iter().skip(1).take_while(|token| !token.is(">")).map(|token| &*token.text).collect()
            }
            _ => return Err(self.error(keyword.origin, "#include takes \"FILE\" or <FILE>")),
        };
        if depth >= MOST_DEPTH {
            return Err(self.error(keyword.origin, format!("files include each other more than {MOST_DEPTH} deep")));
        }
        let beside = self.files.get(index).and_then(|file| file.directory.clone());
        let directories = beside.iter().chain(&self.environment.include);
        let Some(path) = found(directories.clone(), &wanted, self.language) else {
            let looked: Vec<String> = directories.map(|directory| directory.display().to_string()).collect();
            let looked = if looked.is_empty() { "nowhere: no -I is given".to_owned() } else { looked.join(", ") };
            let message =
                format!("`{wanted}` is not found; give the directory that it is in with -I (looked in {looked})");
            return Err(self.error(keyword.origin, message));
        };
        let text = read(&path).map_err(|reason| self.error(keyword.origin, format!("{}: {reason}", path.display())))?;
        let directory = path.parent().map(Path::to_path_buf);
        let added = add(self.files, &path.display().to_string(), &text, directory)?;
        self.file(added, depth + 1)
    }
}

/// A file's text, or why it cannot be had.
pub(super) fn read(path: &Path) -> Result<String, String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    String::from_utf8(bytes)
        .map_err(|error| format!("not a text: byte {} is not UTF-8", error.utf8_error().valid_up_to()))
}

/// The first file of that name in the directories; names without an ending may lack a shader's.
fn found<'a>(directories: impl Iterator<Item = &'a PathBuf>, name: &str, language: Language) -> Option<PathBuf> {
    // Engines of both languages have a file of the same name for each, side by side.
    let endings: &[&str] = match language {
        Language::Glsl => &["", ".glsl", ".glsl.js", ".fx", ".fs", ".frag"],
        Language::Wgsl => &["", ".wgsl", ".wesl", ".wgsl.js", ".fx"],
    };
    for directory in directories {
        for ending in endings {
            let path = directory.join(format!("{name}{ending}"));
            if path.is_file() {
                return Some(path);
            }
        }
    }
    None
}

/// Where the braces that open in a line are closed again.
fn closed(tokens: &[Token], start: usize, end: usize) -> usize {
    let mut depth = 0i64;
    for (at, token) in tokens.iter().enumerate().skip(start) {
        depth += i64::from(token.is("{")) - i64::from(token.is("}"));
        if depth <= 0 && at + 1 >= end {
            return at + 1;
        }
    }
    tokens.len()
}

#[cfg(test)]
mod tests {
    use super::super::lexer::words;
    use super::*;

    fn run(text: &str, language: Language, defines: &[&str]) -> Result<String, String> {
        let environment =
            Environment { defines: defines.iter().map(|d| (*d).to_owned()).collect(), ..Default::default() };
        let mut files = Vec::new();
        let index = add(&mut files, "a", text, None).unwrap();
        let mut macros = Macros::new(&environment.defines).map_err(|error| error.to_string())?;
        let done =
            preprocess(&mut files, index, language, &environment, &mut macros).map_err(|error| error.to_string())?;
        Ok(done.tokens.iter().map(|token| &*token.text).collect::<Vec<_>>().join(" "))
    }
    fn glsl(text: &str) -> String {
        run(text, Language::Glsl, &[]).unwrap_or_else(|error| error)
    }

    #[test]
    fn macros_expand() {
        assert_eq!(glsl("#define PI 3.14\n#define TAU (2.0*PI)\nTAU"), "( 2.0 * 3.14 )");
        assert_eq!(
            glsl("#define saturate( a ) clamp( a, 0.0, 1.0 )\nsaturate(dot(n, l))"),
            "clamp ( dot ( n , l ) , 0.0 , 1.0 )"
        );
        assert_eq!(glsl("#define F(x) F(x + 1)\nF(F(y)) F"), "F ( F ( y + 1 ) + 1 ) F");
        assert_eq!(glsl("#define A B\n#define B A\nA B"), "A B");
        assert_eq!(glsl("#define CAT(a, b) a##_##b\nCAT(x, y)"), "x_y");
        assert_eq!(glsl("#define G F\n#define F(x) x*x\nG(2) \\\n+ F(\n3)"), "2 * 2 + 3 * 3");
        assert_eq!(glsl("#define N() 1\nN() N"), "1 N");
        assert_eq!(glsl("#define F (x)\nF #undef"), "( x ) # undef");
        assert_eq!(glsl("#define X 1\n#undef X\nX"), "X");
        assert_eq!(run("W", Language::Glsl, &["W=vec3(1, 2, 3)", "Q"]).unwrap(), "vec3 ( 1 , 2 , 3 )");
    }

    #[test]
    fn conditions_choose() {
        let text = "#if defined(A) && B >= 2\none\n#elif !defined C || (B << 1) == 2\ntwo\n#else\nthree\n#endif\nend";
        assert_eq!(run(text, Language::Glsl, &["A", "B=2"]).unwrap(), "one end");
        assert_eq!(run(text, Language::Glsl, &["C", "B=1"]).unwrap(), "two end");
        assert_eq!(run(text, Language::Glsl, &["C", "B=0"]).unwrap(), "three end");
        assert_eq!(
            glsl("#ifndef X\n#define X\n#ifdef X\na\n#endif\n#endif\n#if 0\n#if 1\nb\n#else\nc\n#endif\n#endif"),
            "a"
        );
        // What a branch not taken says does not matter.
        assert_eq!(glsl("#if 0\n#error no\n#include \"none\"\n#if junk ((\n#endif\n#endif\nx"), "x");
        let oil = "#ifdef A\na\n#else ifdef B\nb\n#else\nc\n#endif\nlet n = #{N}u;";
        assert_eq!(run(oil, Language::Wgsl, &["B", "N=4"]).unwrap(), "b let n = 4 u ;");
    }

    #[test]
    fn errors_name_the_place() {
        for (text, want) in [
            ("\n  #if 1\nx", "a:2:3: this condition has no #endif"),
            ("x\n#endif", "a:2:1: #endif without #if"),
            ("#else", "a:1:1: #else without #if"),
            ("#if 1\n#else\n#else\n#endif", "a:3:1: #else after #else"),
            ("#if 1 +\n#endif", "a:1:2: #if: the condition ends too early"),
            ("#if 1 / 0\n#endif", "a:1:2: #if: a division by 0"),
            ("#define F(a, b) a\nx = F(1);", "a:2:5: the macro `F` takes 2 arguments, not 1"),
            ("#define F(a) a\nx = F(1;", "a:2:5: `F(` has no `)`"),
            ("#define F(a b) a", "a:1:13: a macro's parameters are names with commas between them"),
            ("#define 3", "a:1:2: #define names no macro"),
            ("#error bad thing", "a:1:1: #error bad thing"),
            ("#frobnicate", "a:1:2: the directive `#frobnicate` is not known"),
            ("#include <x/y.glsl>", "a:1:2: `x/y.glsl` is not found; give the directory that it is in with -I"),
        ] {
            let error = run(text, Language::Glsl, &[]).unwrap_err();
            assert!(error.starts_with(want), "{text}: {error}");
        }
        let bomb: String = (0..64).map(|i| format!("#define A{} A{i} A{i}\n", i + 1)).collect();
        assert!(glsl(&format!("{bomb}A64")).contains("more than 1048576 tokens"));
        let chain: String = (0..100_000).map(|i| format!("#define A{} A{i}\n", i + 1)).collect();
        assert!(glsl(&format!("{chain}A99999")).contains("lead to each other"));
        assert!(run("", Language::Glsl, &["2x"]).unwrap_err().contains("is not a name"));
    }

    #[test]
    fn scripts_hold_their_shader() {
        let text = "export default /* glsl */`\nfloat pow2( const in float x ) { return x*x; }\n`;\n";
        assert_eq!(words(&without_script(text)).first().map(|word| word.to_string()), Some("float".into()));
        assert_eq!(without_script("void f() { } // `a` export `b`"), "void f() { } // `a` export `b`");
    }
}
