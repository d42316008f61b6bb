//! A rough tokenizer of scripts, for what the engine's own keeps to itself: how wide the token at a
//! position is, where a key of an object map stands, whether an input is complete, and which names
//! a text declares.

/// What a token is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// A name or keyword.
    Word,
    /// A number.
    Number,
    /// A text or character with its quotes.
    Text,
    /// One character of an operator, or a bracket.
    Symbol,
    /// A comment.
    Comment,
}

/// A token with its place.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Token<'a> {
    /// What it is.
    pub kind: Kind,
    /// Its text.
    pub text: &'a str,
    /// Line from 1.
    pub line: u32,
    /// Column from 1, in characters.
    pub column: u32,
    /// Where it starts, in bytes.
    pub start: usize,
    /// Whether it has an end; texts and block comments may lack one.
    pub closed: bool,
}

impl Token<'_> {
    /// Where it ends, in bytes.
    pub fn end(&self) -> usize {
        self.start + self.text.len()
    }
}

/// The tokens of a text; anything at all has some.
pub fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut scan = Scan { rest: text, line: 1, column: 1 };
    let mut found = Vec::new();
    while let Some(c) = scan.rest.chars().next() {
        if c.is_whitespace() {
            scan.take(c.len_utf8());
            continue;
        }
        let (line, column, start) = (scan.line, scan.column, text.len() - scan.rest.len());
        let (kind, length, closed) = extent(scan.rest, c);
        found.push(Token { kind, text: scan.take(length), line, column, start, closed });
    }
    found
}

/// The tokens of a text that are not comments.
pub fn code(text: &str) -> Vec<Token<'_>> {
    tokens(text).into_iter().filter(|t| t.kind != Kind::Comment).collect()
}

/// Which bracket closes the one with this number.
pub fn closing(tokens: &[Token<'_>], open: usize) -> Option<usize> {
    let mut depth = 0i32;
    for (i, token) in tokens.iter().enumerate().skip(open) {
        match token.text {
            "(" | "{" | "[" => depth += 1,
            ")" | "}" | "]" => depth -= 1,
            _ if i == open => return None,
            _ => {}
        }
        if depth == 0 {
            return Some(i);
        }
    }
    None
}

struct Scan<'a> {
    rest: &'a str,
    line: u32,
    column: u32,
}

impl<'a> Scan<'a> {
    fn take(&mut self, length: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(length);
        self.rest = rest;
        for c in taken.chars() {
            if c == '\n' {
                self.line += 1;
                self.column = 1;
            } else {
                self.column += 1;
            }
        }
        taken
    }
}

/// Kind and length in bytes of the token at the start of a text, and whether it has an end.
fn extent(rest: &str, first: char) -> (Kind, usize, bool) {
    let until = |end: fn(char) -> bool| rest.find(end).unwrap_or(rest.len());
    if rest.starts_with("//") {
        return (Kind::Comment, rest.find('\n').unwrap_or(rest.len()), true);
    }
    if rest.starts_with("/*") {
        return block_comment(rest);
    }
    match first {
        '`' => template(rest),
        '"' => quoted(rest, first),
        // A lifetime-like lone quote is a symbol.
        '\'' if rest[1..].chars().take(8).any(|c| c == '\'') => quoted(rest, first),
        c if c.is_alphabetic() || c == '_' => {
            (Kind::Word, until(|c| !(c.is_alphanumeric() || c == '_')), true)
        }
        c if c.is_ascii_digit() => (Kind::Number, number(rest), true),
        c => (Kind::Symbol, c.len_utf8(), true),
    }
}

fn block_comment(rest: &str) -> (Kind, usize, bool) {
    let (mut depth, mut at) = (0usize, 0);
    while at < rest.len() {
        let here = &rest[at..];
        if here.starts_with("/*") {
            depth += 1;
            at += 2;
        } else if here.starts_with("*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return (Kind::Comment, at, true);
            }
        } else {
            at += here.chars().next().map_or(1, char::len_utf8);
        }
    }
    (Kind::Comment, rest.len(), false)
}

/// A text between backticks, with the scripts that are in it, which may have such texts of their own.
fn template(rest: &str) -> (Kind, usize, bool) {
    // Of each script that is open, within the text around it, the braces; and whether a text is open within the last.
    let (mut braces, mut is_text, mut at) = (Vec::new(), true, 1);
    while let Some(c) = rest[at..].chars().next() {
        if is_text {
            let is_script = rest[at..].starts_with("${");
            if c == '`' && braces.is_empty() {
                return (Kind::Text, at + 1, true);
            }
            if is_script {
                braces.push(0usize);
            }
            at += if is_script { 1 } else { c.len_utf8() };
            is_text = c != '`' && !is_script;
            continue;
        }
        at += if c == '`' || c.is_whitespace() { c.len_utf8() } else { extent(&rest[at..], c).1 };
        is_text = c == '`';
        if let Some(open) = braces.last_mut() {
            *open = if c == '}' { open.saturating_sub(1) } else { *open + usize::from(c == '{') };
            if c == '}' && *open == 0 {
                braces.pop();
                is_text = true;
            }
        }
    }
    (Kind::Text, rest.len(), false)
}

fn quoted(rest: &str, quote: char) -> (Kind, usize, bool) {
    let mut escaped = false;
    for (i, c) in rest.char_indices().skip(1) {
        if escaped {
            escaped = false;
        } else if c == '\\' {
            escaped = true;
        } else if c == quote {
            return (Kind::Text, i + 1, true);
        } else if c == '\n' {
            return (Kind::Text, i, false);
        }
    }
    (Kind::Text, rest.len(), false)
}

fn number(rest: &str) -> usize {
    let bytes = rest.as_bytes();
    let mut end = 0;
    while end < bytes.len() {
        let next = bytes.get(end + 1).copied();
        let fine = match bytes[end] {
            b'0'..=b'9' | b'a'..=b'z' | b'A'..=b'Z' | b'_' => true,
            b'.' => next.is_some_and(|c| c.is_ascii_digit()),
            b'+' | b'-' => matches!(bytes[end - 1], b'e' | b'E') && next.is_some_and(|c| c.is_ascii_digit()),
            _ => false,
        };
        if !fine {
            break;
        }
        end += 1;
    }
    end
}

/// Width of the token at a position; 1 where there is none.
pub fn width_at(text: &str, line: u32, column: u32) -> u32 {
    let at = tokens(text).into_iter().find(|t| t.line == line && t.column == column);
    let Some(token) = at else { return 1 };
    let first = token.text.lines().next().unwrap_or("");
    match token.kind {
        // Operators of several characters are several tokens here.
        Kind::Symbol => operator(text, line, column),
        _ => first.chars().count().max(1) as u32,
    }
}

fn operator(text: &str, line: u32, column: u32) -> u32 {
    const WIDE: [&str; 13] = ["..=", "**=", "==", "!=", "<=", ">=", "**", "..", "&&", "||", "+=", "-=", "#{"];
    let rest: String = text
        .lines()
        .nth(line.saturating_sub(1) as usize)
        .map(|l| l.chars().skip(column.saturating_sub(1) as usize).take(3).collect())
        .unwrap_or_default();
    WIDE.iter().find(|op| rest.starts_with(**op)).map_or(1, |op| op.len() as u32)
}

/// Place of a key in the object map of a call: the first `key:` after the call's name, before its
/// closing bracket. The value after it is where a wrong value is meant.
pub fn key_after(text: &str, line: u32, column: u32, key: &str) -> Option<(u32, u32, u32)> {
    let all = code(text);
    let start = all.iter().position(|t| (t.line, t.column) >= (line, column))?;
    let mut depth = 0i32;
    for (i, token) in all.iter().enumerate().skip(start) {
        match token.text {
            "(" | "{" | "[" => depth += 1,
            ")" | "}" | "]" => {
                depth -= 1;
                if depth <= 0 {
                    return None;
                }
            }
            text if depth == 2 && text.trim_matches('"') == key => {
                let colon = all.get(i + 1).is_some_and(|t| t.text == ":");
                if colon {
                    return Some((token.line, token.column, text.chars().count() as u32));
                }
            }
            _ => {}
        }
    }
    None
}

/// Place of an argument of a call, counted from 0: where it begins, and how wide it is on that line. The first of a method is
/// what that is a method of, and has none.
pub fn argument_of(text: &str, line: u32, column: u32, number: usize) -> Option<(u32, u32, u32)> {
    let all = code(text);
    let name = all.iter().position(|t| (t.line, t.column) >= (line, column))?;
    let is_method = name > 0 && all[name - 1].text == ".";
    let mut left = number.checked_sub(usize::from(is_method))?;
    let open = name + all[name..].iter().position(|t| t.text == "(")?;
    let (close, mut i) = (closing(&all, open)?, open + 1);
    let mut found: Option<(u32, u32, u32)> = None;
    while i < close {
        let first = &all[i];
        let last = closing(&all, i).unwrap_or(i);
        if first.text == "," {
            if left == 0 {
                break;
            }
            left -= 1;
        } else if left == 0 {
            let (line, column, _) = *found.get_or_insert((first.line, first.column, 1));
            let last = &all[last];
            let end = last.column + last.text.chars().count() as u32;
            found = found.map(|own| if last.line == line { (line, column, end - column) } else { own });
        }
        i = last + 1;
    }
    found
}

/// The brackets that are open at the end of some tokens, the innermost last, each with its number.
pub fn open_brackets(tokens: &[Token<'_>]) -> Vec<usize> {
    let mut open = Vec::new();
    for (i, token) in tokens.iter().enumerate() {
        match token.text {
            "(" | "{" | "[" => open.push(i),
            ")" | "}" | "]" => drop(open.pop()),
            _ => {}
        }
    }
    open
}

/// Whether a bracket, text or comment is still open, so that more lines must follow.
pub fn is_open(text: &str) -> bool {
    let mut depth = 0i32;
    let mut last = "";
    for token in tokens(text) {
        if !token.closed {
            // A text with straight quotes ends with its line, right or wrong.
            return token.kind == Kind::Comment || token.text.starts_with('`');
        }
        if token.kind == Kind::Comment {
            continue;
        }
        match token.text {
            "(" | "{" | "[" => depth += 1,
            ")" | "}" | "]" => depth -= 1,
            _ => {}
        }
        last = token.text;
    }
    depth > 0 || (depth == 0 && matches!(last, "+" | "-" | "*" | "/" | "=" | "," | "." | "%" | "|" | "&"))
}

/// The innermost bracket that is never closed.
pub fn unclosed(text: &str) -> Option<Token<'_>> {
    let tokens = tokens(text);
    open_brackets(&tokens).last().map(|i| tokens[*i])
}

/// Names that a text declares: variables, constants, functions with their parameters, and modules.
pub fn declared(text: &str) -> Vec<&str> {
    let all = code(text);
    let mut names = Vec::new();
    for pair in all.windows(2) {
        let declares = matches!(pair[0].text, "let" | "const" | "fn" | "as" | "for");
        if declares && pair[1].kind == Kind::Word {
            names.push(pair[1].text);
        }
    }
    names
}

/// Names of the variables and constants that a text declares.
pub fn variables(text: &str) -> Vec<&str> {
    let all = code(text);
    let declares =
        |pair: &&[Token<'_>]| matches!(pair[0].text, "let" | "const" | "for") && pair[1].kind == Kind::Word;
    all.windows(2).filter(declares).map(|pair| pair[1].text).collect()
}

/// Names of the modules that a text imports.
pub fn modules(text: &str) -> Vec<&str> {
    let all = code(text);
    let named = |three: &[Token<'_>]| {
        three[0].kind == Kind::Text && three[1].text == "as" && three[2].kind == Kind::Word
    };
    all.windows(3).filter(|three| named(three)).map(|three| three[2].text).collect()
}

/// A definition of a function, and where it is, in bytes.
pub struct Definition {
    /// Its name.
    pub name: String,
    /// Names of its parameters.
    pub parameters: Vec<String>,
    /// Whether others cannot call it.
    pub is_private: bool,
    /// Whether it asks what it is a method of.
    pub uses_this: bool,
    /// Where it begins, with what makes it private.
    pub start: usize,
    /// Where it ends.
    pub end: usize,
}

/// The functions that a text defines.
pub fn definitions(text: &str) -> Vec<Definition> {
    let tokens = code(text);
    let mut found = Vec::new();
    for (i, token) in tokens.iter().enumerate().filter(|(_, t)| t.text == "fn") {
        let [name, open, ..] = &tokens[i + 1..] else { continue };
        let close = closing(&tokens, i + 2).filter(|_| open.text == "(" && name.kind == Kind::Word);
        let Some(close) = close else { continue };
        let Some(end) = closing(&tokens, close + 1) else { continue };
        let parameters = tokens[i + 3..close].iter().filter(|t| t.kind == Kind::Word);
        let is_private = i > 0 && tokens[i - 1].text == "private";
        found.push(Definition {
            name: name.text.to_owned(),
            parameters: parameters.map(|t| t.text.to_owned()).collect(),
            is_private,
            uses_this: tokens[close..end].iter().any(|t| t.text == "this"),
            start: if is_private { tokens[i - 1].start } else { token.start },
            end: tokens[end].end(),
        });
    }
    found
}

/// A documented function of a module.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Documented {
    /// Its name.
    pub name: String,
    /// Its name and parameters.
    pub signature: String,
    /// The text of its `///` comment, without indented or fenced code.
    pub doc: String,
    /// The first line of code in the comment.
    pub example: String,
}

/// How many there are in a list with commas, in brackets or not.
pub fn parameters(list: &str) -> usize {
    let list = list.split_once('(').map_or(list, |(_, list)| list).trim_end_matches(')');
    if list.trim().is_empty() { 0 } else { list.split(',').count() }
}

/// The public functions of a module with the `///` comments above them.
pub fn functions(text: &str) -> Vec<Documented> {
    let (mut found, mut comment) = (Vec::new(), Vec::new());
    for line in text.lines() {
        if let Some(doc) = line.strip_prefix("///") {
            comment.push(doc.strip_prefix(' ').unwrap_or(doc));
            continue;
        }
        if let Some(rest) = line.strip_prefix("fn ")
            && let Some((head, _)) = rest.split_once(')')
        {
            let name = head.split('(').next().unwrap_or(head).trim().to_owned();
            let is_code = |l: &&&str| l.starts_with("    ");
            let doc: Vec<&str> =
                comment.iter().filter(|l| !is_code(l)).copied().filter(|l| !l.is_empty()).collect();
            let example = comment.iter().find(is_code).map_or("", |l| l.trim());
            let signature = format!("{head})");
            found.push(Documented { name, signature, doc: doc.join(" "), example: example.to_owned() });
        }
        comment.clear();
    }
    found
}
