//! Finds the genes of a text by its tokens: where operands begin, and how far they go.

use super::{Form, Gene, Genes};
use crate::script::engine::{INPUTS, KEYWORDS};
use crate::script::lexer::{Kind, Token, code};
use std::collections::BTreeMap;
use std::ops::Range;

/// Where the gene of an import stands that names a module of the standard library.
const STD: &str = "std/";

/// Functions whose calls stay as they are: parameters have values of their own, and how a solid is photographed does not make
/// it another one.
const APART: [&str; 8] = ["param", "preset", "film", "orbit", "look_at", "panorama", "cube_map", "walk"];

/// A text in tokens.
pub struct Reader<'a> {
    text: &'a str,
    tokens: Vec<Token<'a>>,
    /// The bracket that closes one.
    partner: Vec<Option<usize>>,
    /// What is no expression, and what shall not change.
    skip: Vec<bool>,
    /// Names under which modules were imported, with their own.
    modules: BTreeMap<&'a str, &'a str>,
    declared: Vec<(String, usize)>,
    bodies: Vec<Range<usize>>,
}

impl<'a> Reader<'a> {
    /// Of a text whose brackets and quotes all close.
    pub fn new(text: &'a str) -> Option<Reader<'a>> {
        let tokens = code(text);
        let mut partner = vec![None; tokens.len()];
        let mut open = Vec::new();
        for (i, token) in tokens.iter().enumerate() {
            match token.text {
                "(" | "[" | "{" => open.push(i),
                ")" | "]" | "}" => partner[open.pop()?] = Some(i),
                _ if !token.closed => return None,
                _ => {}
            }
        }
        let skip = vec![false; tokens.len()];
        let (modules, declared, bodies) = Default::default();
        let mut reader = Reader { text, tokens, partner, skip, modules, declared, bodies };
        reader.survey();
        open.is_empty().then_some(reader)
    }

    /// The text of a token; none where there is no token.
    fn at(&self, i: usize) -> &'a str {
        self.tokens.get(i).map_or("", |t| t.text)
    }

    fn kind(&self, i: usize) -> Option<Kind> {
        self.tokens.get(i).map(|t| t.kind)
    }

    fn is_word(&self, i: usize) -> bool {
        self.kind(i) == Some(Kind::Word)
    }

    /// Whether a token follows the one before without a space.
    fn touches(&self, i: usize) -> bool {
        i > 0 && self.tokens.get(i).is_some_and(|t| t.start == self.tokens[i - 1].end())
    }

    /// The token before one; none at the start.
    fn before(&self, i: usize) -> &'a str {
        i.checked_sub(1).map_or("", |i| self.at(i))
    }

    /// Whether two colons that belong together begin there.
    fn is_path(&self, i: usize) -> bool {
        self.at(i) == ":" && self.at(i + 1) == ":" && self.touches(i + 1)
    }

    /// The token after the bracket that closes one.
    fn after(&self, open: usize) -> Option<usize> {
        self.partner.get(open).copied().flatten().map(|close| close + 1)
    }

    fn leave_out(&mut self, range: Range<usize>) {
        let end = range.end.min(self.skip.len());
        self.skip[range.start.min(end)..end].fill(true);
    }

    /// The first of these after a token, or the end.
    fn until(&self, from: usize, ends: &[&str]) -> usize {
        (from..self.tokens.len()).find(|i| ends.contains(&self.at(*i))).unwrap_or(self.tokens.len())
    }

    /// The end of a statement that begins at a token.
    fn statement(&self, i: usize) -> usize {
        let mut end = i;
        while !matches!(self.at(end), "" | ";" | "}" | ")" | "]") {
            end = self.after(end).unwrap_or(end + 1);
        }
        end
    }

    fn declare(&mut self, range: Range<usize>) {
        for i in range.filter(|i| self.is_word(*i)).collect::<Vec<_>>() {
            self.declared.push((self.at(i).to_owned(), self.tokens[i].start));
        }
    }

    /// Finds what is left out, and what is declared.
    fn survey(&mut self) {
        for i in 0..self.tokens.len() {
            if self.skip[i] {
                continue;
            }
            match self.at(i) {
                "import" => self.import(i),
                "let" | "const" => {
                    // Its value does not know it yet.
                    let from = self.tokens.get(self.statement(i)).map_or(self.text.len(), |t| t.start);
                    self.declared.push((self.at(i + 1).to_owned(), from));
                    self.leave_out(i..i + 2);
                }
                "as" => self.leave_out(i..i + 2),
                "fn" => self.function(i),
                "for" => {
                    let end = self.until(i, &["in", "{"]);
                    self.declare(i + 1..end);
                    self.leave_out(i..end + 1);
                }
                "catch" => {
                    let end = self.until(i, &["{"]);
                    self.declare(i + 1..end);
                    self.leave_out(i..end);
                }
                name if APART.contains(&name) && self.at(i + 1) == "(" && self.before(i) != "." => {
                    let end = self.after(i + 1).unwrap_or(i);
                    self.leave_out(i..end);
                }
                "|" if self.begins(i, true) => {
                    let end = self.until(i + 1, &["|"]);
                    self.leave_out(i..end + 1);
                }
                _ if self.is_key(i) => self.leave_out(i..i + 1),
                _ => {}
            }
        }
    }

    fn import(&mut self, i: usize) {
        let end = self.until(i, &[";"]);
        let path = self.at(i + 1).trim_matches('"');
        if self.at(i + 2) == "as" && self.is_word(i + 3) {
            self.modules.insert(self.at(i + 3), path.strip_prefix(STD).unwrap_or(path));
        }
        self.leave_out(i..end);
    }

    fn function(&mut self, i: usize) {
        let open = self.until(i, &["(", "{"]);
        let end = self.after(open).unwrap_or(open);
        let body = self.until(end, &["{"]);
        if self.at(open) == "("
            && let Some(close) = self.after(body)
        {
            self.bodies.push(self.tokens[i].start..self.tokens[close - 1].end());
            self.declare(open + 1..end);
            self.leave_out(i..end);
        }
    }

    /// Whether a token is a key of an object map.
    fn is_key(&self, i: usize) -> bool {
        matches!(self.kind(i), Some(Kind::Word | Kind::Text))
            && self.at(i + 1) == ":"
            && !self.is_path(i + 1)
            && matches!(self.before(i), "{" | ",")
    }

    /// Whether an operand begins at a token; anything may where only what is before it counts.
    fn begins(&self, i: usize, anything: bool) -> bool {
        let fits = match self.tokens[i].kind {
            Kind::Word => !KEYWORDS.contains(&self.at(i)),
            Kind::Number | Kind::Text => true,
            _ => matches!(self.at(i), "(" | "[") || self.at(i) == "#" && self.at(i + 1) == "{",
        };
        if !fits && !anything || self.skip[i] {
            return false;
        }
        let Some(last) = i.checked_sub(1) else { return true };
        match (self.kind(last), self.at(last)) {
            _ if self.skip[last] => true,
            (Some(Kind::Word), word) => {
                KEYWORDS.contains(&word)
                    && !matches!(word, "this" | "true" | "false" | "print" | "debug" | "type_of" | "global")
            }
            (Some(Kind::Number | Kind::Text), _) | (_, ")" | "]") => false,
            // What is in brackets there may be an index or the like.
            (_, "}") => !matches!(self.at(i), "(" | "["),
            (_, "|") if self.at(i) == "|" => !self.touches(i),
            (_, ".") => self.before(last) == "." && self.touches(last),
            (_, ":") => !(self.before(last) == ":" && self.touches(last)),
            _ => true,
        }
    }

    /// The end of a chain that begins at a token.
    fn chain(&self, i: usize) -> Option<usize> {
        let mut end = match self.kind(i)? {
            Kind::Word if !KEYWORDS.contains(&self.at(i)) => {
                let mut end = i + 1;
                while self.is_path(end) && self.is_word(end + 2) {
                    end += 3;
                }
                if self.at(end) == "(" { self.after(end)? } else { end }
            }
            Kind::Number | Kind::Text => i + 1,
            Kind::Symbol if matches!(self.at(i), "(" | "[") => self.after(i)?,
            Kind::Symbol if self.at(i) == "#" && self.at(i + 1) == "{" => self.after(i + 1)?,
            _ => return None,
        };
        loop {
            if self.at(end) == "." && self.is_word(end + 1) {
                end += 2;
                if self.at(end) == "(" {
                    end = self.after(end)?;
                }
            } else if self.at(end) == "[" && self.touches(end) {
                end = self.after(end)?;
            } else {
                return Some(end);
            }
        }
    }

    /// The operand after one of these operators, if there is one.
    fn operand(&self, i: usize, operators: &[&str]) -> Option<usize> {
        let mut next = i + 1;
        if !operators.contains(&self.at(i)) {
            return None;
        }
        if self.at(i) == "*" && self.at(next) == "*" && self.touches(next) {
            next += 1;
        }
        let assigns = self.at(next) == "=" && self.touches(next);
        if !assigns && matches!(self.at(next), "-" | "+") {
            next += 1;
        }
        (!assigns).then_some(next)
    }

    /// The end of a product that begins at a token, and how many operators it has.
    fn product(&self, i: usize) -> Option<(usize, usize)> {
        let (mut end, mut count) = (self.chain(i)?, 0);
        while let Some(next) = self.operand(end, &["*", "/", "%"]) {
            end = self.chain(next)?;
            count += 1;
        }
        Some((end, count))
    }

    /// The same of a sum.
    fn sum(&self, i: usize) -> Option<(usize, usize)> {
        let (mut end, mut count) = (self.product(i)?.0, 0);
        while let Some(next) = self.operand(end, &["+", "-"]) {
            end = self.product(next)?.0;
            count += 1;
        }
        Some((end, count))
    }

    /// Whether what ends before a token is assigned to, or is the pattern of a case.
    fn is_assigned(&self, i: usize) -> bool {
        let is_next = |i: usize| self.at(i) == "=" && !(self.at(i + 1) == "=" && self.touches(i + 1));
        let mut i = i;
        if matches!(self.at(i), "+" | "-" | "*" | "/" | "%" | "&" | "|" | "^") {
            i += 1 + usize::from(self.at(i) == "*" && self.at(i + 1) == "*");
            return self.touches(i) && is_next(i);
        }
        is_next(i)
    }

    /// All genes.
    pub fn genes(self) -> Genes {
        let mut all = Vec::new();
        for i in 0..self.tokens.len() {
            if self.begins(i, false) {
                self.operands(i, &mut all);
            }
            if !self.skip[i] {
                all.extend(self.name(i).or_else(|| self.sign(i)));
            }
        }
        Genes { all, text: self.text.to_owned(), declared: self.declared, bodies: self.bodies }
    }

    /// The chain, the product and the sum that begin at a token.
    fn operands(&self, i: usize, all: &mut Vec<Gene>) {
        let Some(end) = self.chain(i) else { return };
        let is_lone = end == i + 1;
        match self.kind(i) {
            _ if self.is_assigned(end) => {}
            Some(Kind::Number) if is_lone => all.push(self.gene(Form::Number, i..end)),
            Some(Kind::Text) if is_lone => {}
            _ => all.extend(self.subtree(Form::Chain, i..end)),
        }
        if matches!(self.before(i), "*" | "/" | "%") {
            return;
        }
        let product = self.product(i).filter(|(_, count)| *count > 0);
        all.extend(product.and_then(|(end, _)| self.subtree(Form::Product, i..end)));
        if matches!(self.before(i), "+" | "-") {
            return;
        }
        let sum = self.sum(i).filter(|(_, count)| *count > 0);
        all.extend(sum.and_then(|(end, _)| self.subtree(Form::Sum, i..end)));
    }

    /// A subtree; none that makes a parameter, which has to be made in one place.
    fn subtree(&self, form: Form, range: Range<usize>) -> Option<Gene> {
        let makes = range.clone().any(|i| matches!(self.at(i), "param" | "preset") && self.at(i + 1) == "(");
        (!makes).then(|| self.gene(form, range))
    }

    fn gene(&self, form: Form, range: Range<usize>) -> Gene {
        let opens = matches!(self.before(range.start), "" | "(" | "[" | "{" | "," | ";" | "=" | ":");
        let closes = matches!(self.at(range.end), "" | ")" | "]" | "}" | "," | ";");
        let names = range.clone().filter(|i| self.is_variable(*i)).map(|i| self.at(i).to_owned()).collect();
        let bytes = self.tokens[range.start].start..self.tokens[range.end - 1].end();
        Gene { form, range: bytes, sort: None, alone: opens && closes, names }
    }

    /// Whether a token is the name of a variable of the script.
    fn is_variable(&self, i: usize) -> bool {
        let word = self.at(i);
        let is_input = matches!(word, "p" | "PI" | "TAU") || INPUTS.iter().any(|(name, _)| *name == word);
        self.is_word(i)
            && !KEYWORDS.contains(&word)
            && !is_input
            && self.at(i + 1) != "("
            && !self.is_path(i + 1)
            && !self.is_key(i)
            && (self.before(i) != "." || self.begins(i, false))
    }

    /// The name of a function that is called.
    fn name(&self, i: usize) -> Option<Gene> {
        let is_call = self.is_word(i) && !KEYWORDS.contains(&self.at(i)) && self.at(i + 1) == "(";
        if !is_call {
            return None;
        }
        let close = self.after(i + 1)? - 1;
        let (mut count, mut at) = (usize::from(close > i + 2), i + 2);
        while at < close {
            count += usize::from(self.at(at) == "," && at + 1 < close);
            at = self.after(at).unwrap_or(at + 1);
        }
        let is_method = self.before(i) == "." && !self.begins(i, false);
        let full = match i.checked_sub(3) {
            Some(module) if self.is_path(i - 2) => {
                let alias = self.at(module);
                format!("{}::{}", self.modules.get(alias).unwrap_or(&alias), self.at(i))
            }
            _ => self.at(i).to_owned(),
        };
        Some(self.gene(Form::Name { full, arity: count + usize::from(is_method) }, i..i + 1))
    }

    /// A plus or minus between operands.
    fn sign(&self, i: usize) -> Option<Gene> {
        let ends = match self.kind(i.checked_sub(1)?)? {
            Kind::Word => !KEYWORDS.contains(&self.before(i)),
            Kind::Number | Kind::Text => true,
            _ => matches!(self.before(i), ")" | "]"),
        };
        let is_sign = matches!(self.at(i), "+" | "-") && ends && self.operand(i, &["+", "-"]).is_some();
        is_sign.then(|| self.gene(Form::Sign, i..i + 1))
    }
}
