//! Genes of a script: the pieces of its text that can be exchanged for others, so that what comes of it is a script too.
//!
//! Numbers, the names of functions, `+` and `-`, and subtrees: calls with their methods, products and sums. What is in
//! texts and comments is none, nor what belongs to parameters, cameras, film and imports, to heads of functions and loops, and
//! to assignments to something. What a subtree is, a field or a noise, is found out by a run of the script in which each says
//! so itself.

mod kin;
mod reader;

pub use kin::Kin;

use super::library::Entry;
use super::noises::Source;
use super::value::{Field, VectorField};
use super::{Request, execute};
use reader::Reader;
use rhai::{Dynamic, INT, NativeCallContext};
use std::any::TypeId;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Range;
use std::rc::Rc;

/// What a subtree is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Sort {
    /// A scalar of the point.
    Field,
    /// A vector of the point.
    VectorField,
    /// A source of noise.
    Noise,
}

/// What a gene is.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Form {
    /// A number.
    Number,
    /// The name of a function, with its module and its number of arguments, the one before the dot included.
    Name {
        /// As the reference has it: `fractal::ridged`.
        full: String,
        /// How many arguments it is given.
        arity: usize,
    },
    /// A `+` or `-` between two operands.
    Sign,
    /// What can be an operand of anything: a call, a name, or brackets, with methods.
    Chain,
    /// Chains, multiplied and divided.
    Product,
    /// Products, added and subtracted.
    Sum,
}

impl Form {
    /// How closely its parts are bound; the more, the fewer places need brackets around it.
    fn firmness(&self) -> u8 {
        match self {
            Form::Sum => 0,
            Form::Product => 1,
            _ => 2,
        }
    }
}

/// A piece of a script that can be exchanged.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Gene {
    /// What it is.
    pub form: Form,
    /// Where, in bytes.
    pub range: Range<usize>,
    /// What its value is, where it is a subtree, and that was found out.
    pub sort: Option<Sort>,
    /// Whether nothing beside it binds to it.
    alone: bool,
    /// Variables that it speaks of.
    names: Vec<String>,
}

/// The genes of a text.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Genes {
    /// All of them, by their place.
    pub all: Vec<Gene>,
    /// The text.
    pub text: String,
    /// Variables, where they are declared.
    declared: Vec<(String, usize)>,
    /// Where functions are.
    bodies: Vec<Range<usize>>,
}

impl Genes {
    /// Those of a text; what its subtrees are is not known.
    pub fn of(text: &str) -> Genes {
        Reader::new(text).map_or_else(Genes::default, |reader| reader.genes())
    }

    /// Those of a script that runs.
    pub fn read(request: &Request) -> Genes {
        let ran = execute(request, |setup, name, text, _| {
            let mut genes = Genes::of(text);
            let sorts = Rc::new(RefCell::new(BTreeMap::new()));
            let noted = sorts.clone();
            // The text is deeper by one call for every subtree.
            setup.engine.set_max_expr_depths(256, 192);
            setup.engine.register_raw_fn(
                WITNESS,
                [TypeId::of::<INT>(), TypeId::of::<Dynamic>()],
                move |_: NativeCallContext<'_>, args: &mut [&mut Dynamic]| {
                    let value = args[1].flatten_clone();
                    let number = args[0].as_int().unwrap_or_default() as usize;
                    note(&mut noted.borrow_mut(), number, sort(&value));
                    Ok(value)
                },
            );
            // What was found out until it failed is worth knowing.
            let _ = super::evaluate(setup, name, &genes.witnessed());
            for (i, gene) in genes.all.iter_mut().enumerate() {
                gene.sort = sorts.borrow().get(&i).copied().flatten();
            }
            Some(genes)
        });
        ran.value.unwrap_or_default()
    }

    /// The piece of the text that a gene is.
    pub fn words(&self, gene: &Gene) -> &str {
        &self.text[gene.range.clone()]
    }

    /// The text with another piece for a gene.
    pub fn with(&self, site: &Gene, piece: &str) -> String {
        let Range { start, end } = site.range;
        format!("{}{piece}{}", &self.text[..start], &self.text[end..])
    }

    /// What has to stand for a gene so that another one, of this text or of another, takes its place; `None` where its
    /// variables are not known there.
    pub fn graft(&self, site: &Gene, of: &Genes, donor: &Gene) -> Option<String> {
        let home = self.home(site.range.start);
        let knows = |name: &String| {
            let is_it = |(known, at): &(String, usize)| {
                known == name && *at < site.range.start && self.home(*at) == home
            };
            self.declared.iter().any(is_it)
        };
        let words = of.words(donor);
        let fits = site.alone || donor.form.firmness() >= site.form.firmness();
        donor.names.iter().all(knows).then(|| if fits { words.to_owned() } else { format!("({words})") })
    }

    /// The function that a place is in.
    fn home(&self, at: usize) -> Option<usize> {
        self.bodies.iter().position(|body| body.contains(&at))
    }

    /// The text, in which every subtree is handed to a function that notes what it is.
    fn witnessed(&self) -> String {
        let is_tree = |gene: &&(usize, &Gene)| matches!(gene.1.form, Form::Chain | Form::Product | Form::Sum);
        let all: Vec<(usize, &Gene)> = self.all.iter().enumerate().collect();
        let mut starts: Vec<_> = all.iter().filter(is_tree).collect();
        starts.sort_by_key(|(_, gene)| (gene.range.start, std::cmp::Reverse(gene.range.end)));
        let mut ends: Vec<usize> = starts.iter().map(|(_, gene)| gene.range.end).collect();
        ends.sort_unstable();
        let (mut out, mut at) = (String::new(), 0);
        let mut copy = |out: &mut String, to: usize| {
            out.push_str(&self.text[at..to]);
            at = to;
        };
        let mut ends = ends.into_iter().peekable();
        for (i, gene) in starts {
            while let Some(end) = ends.next_if(|end| *end <= gene.range.start) {
                copy(&mut out, end);
                out.push(')');
            }
            copy(&mut out, gene.range.start);
            out += &format!("{WITNESS}({i}, ");
        }
        for end in ends {
            copy(&mut out, end);
            out.push(')');
        }
        copy(&mut out, self.text.len());
        out
    }
}

/// The function that notes what a subtree is; nobody has one of this name.
const WITNESS: &str = "_witness_of_genes";

/// Notes what a subtree is; one that is now this and now that is neither.
fn note(sorts: &mut BTreeMap<usize, Option<Sort>>, number: usize, found: Option<Sort>) {
    let known = sorts.entry(number).or_insert(found);
    if *known != found {
        *known = None;
    }
}

fn sort(value: &Dynamic) -> Option<Sort> {
    if value.is::<Field>() {
        Some(Sort::Field)
    } else if value.is::<VectorField>() {
        Some(Sort::VectorField)
    } else {
        value.is::<Source>().then_some(Sort::Noise)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCRIPT: &str = "import \"std/fractal\" as fractal; // sin(9.0)
let r = param(\"r\", 0.5, 0.1..1.0);
let relief = r * fractal::ridged(gradient(7), #{ octaves: 3, hurst: 0.9 }).scaled(4.0);
fn lump(size) { let half = size / 2; sphere(half) }
let parts = [];
for i in 0..2 { parts.push(lump(1.5).translated([i, 0.25, 0])); }
let n = [1, 2].map(|v| v * 2);
parts[0] = min(parts[0], box(r));
scene(#{ surface: union(parts) - relief + \"7\".len() / 1e3, film: film(#{ width: 640 }), camera: orbit(#{ fov: 21.0 }) })";

    fn words(genes: &Genes, is: impl Fn(&Gene) -> bool) -> Vec<&str> {
        genes.all.iter().filter(|g| is(g)).map(|g| genes.words(g)).collect()
    }

    #[test]
    fn numbers_names_and_subtrees_are_found_and_nothing_else() {
        let genes = Genes::of(SCRIPT);
        let numbers = words(&genes, |g| g.form == Form::Number);
        assert_eq!(
            numbers,
            ["7", "3", "0.9", "4.0", "2", "0", "2", "1.5", "0.25", "0", "1", "2", "2", "0", "0", "1e3"]
        );
        let names = genes.all.iter().filter_map(|g| match &g.form {
            Form::Name { full, arity } => Some((full.as_str(), *arity)),
            _ => None,
        });
        let names: Vec<_> = names.collect();
        for name in [("fractal::ridged", 2), ("gradient", 1), ("scaled", 2), ("translated", 2), ("min", 2)] {
            assert!(names.contains(&name), "{names:?}");
        }
        assert!(names.iter().all(|(name, _)| !["param", "sin"].contains(name)), "{names:?}");
        assert_eq!(words(&genes, |g| g.form == Form::Sign), ["-", "+"]);
        let trees = words(&genes, |g| matches!(g.form, Form::Chain | Form::Product | Form::Sum));
        for tree in ["r", "gradient(7)", "sphere(half)", "size / 2", "i", "min(parts[0], box(r))"] {
            assert!(trees.contains(&tree), "{tree}: {trees:?}");
        }
        let ridged = "fractal::ridged(gradient(7), #{ octaves: 3, hurst: 0.9 }).scaled(4.0)";
        assert!(trees.contains(&ridged) && trees.contains(&format!("r * {ridged}").as_str()));
        assert!(trees.contains(&"union(parts) - relief + \"7\".len() / 1e3"));
        assert!(trees.iter().all(|t| !t.contains("param(") && *t != "octaves"));
    }

    #[test]
    fn subtrees_say_what_they_are() {
        let genes = Genes::read(&Request::text(SCRIPT));
        let of = |sort: Sort| words(&genes, |g| g.sort == Some(sort));
        assert_eq!(
            of(Sort::Noise)[..1],
            ["fractal::ridged(gradient(7), #{ octaves: 3, hurst: 0.9 }).scaled(4.0)"]
        );
        assert!(of(Sort::Noise).contains(&"gradient(7)"));
        for field in [
            "sphere(half)",
            "lump(1.5).translated([i, 0.25, 0])",
            "union(parts) - relief + \"7\".len() / 1e3",
        ] {
            assert!(of(Sort::Field).contains(&field), "{:?}", of(Sort::Field));
        }
        assert!(words(&genes, |g| g.sort.is_some()).iter().all(|w| !["r", "i", "size / 2"].contains(w)));
    }

    #[test]
    fn grafts_have_brackets_where_they_need_them_and_only_known_names() {
        let genes = Genes::read(&Request::text(
            "let a = x; let b = 2 * sin(y); let c = x + y; fn f(q) { abs(q) } f(c) + b * a",
        ));
        let find =
            |words: &str| genes.all.iter().find(|g| genes.words(g) == words && g.sort.is_some()).unwrap();
        let graft = |site: &str, donor: &str| genes.graft(find(site), &genes, find(donor));
        assert_eq!(graft("f(c)", "x + y").unwrap(), "(x + y)");
        assert_eq!(graft("b * a", "2 * sin(y)").unwrap(), "2 * sin(y)");
        assert_eq!(graft("sin(y)", "2 * sin(y)").unwrap(), "(2 * sin(y))");
        assert_eq!(graft("x + y", "sin(y)").unwrap(), "sin(y)");
        assert_eq!(graft("y", "x + y").unwrap(), "x + y");
        assert_eq!(graft("sin(y)", "b * a"), None);
        assert_eq!(graft("f(c)", "abs(q)"), None);
        let text = genes.with(find("f(c)"), "(x + y)");
        assert!(text.ends_with("(x + y) + b * a"), "{text}");
    }

    #[test]
    fn every_script_stays_one_with_witnesses() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let files = ["scripts", "stdlib"].map(|folder| std::fs::read_dir(root.join(folder)).unwrap());
        for file in files.into_iter().flatten().map(|entry| entry.unwrap().path()) {
            if file.extension().is_none_or(|ending| ending != "rhai") {
                continue;
            }
            let text = std::fs::read_to_string(&file).unwrap();
            let fault = execute(&Request::text(text), |setup, _, text, _| {
                let genes = Genes::of(text);
                setup.engine.set_max_expr_depths(256, 192);
                let fault = setup.engine.compile(genes.witnessed()).err().map(|e| e.to_string());
                Some((genes.all.len(), fault))
            });
            let (count, fault) = fault.value.unwrap();
            assert!(count > 5 && fault.is_none(), "{}: {count} {fault:?}", file.display());
        }
    }

    #[test]
    fn what_is_no_script_has_no_genes() {
        for text in ["", "let", "((", "sin(", "\"open", "}", "|", "a..", "param(\"r\", 1"] {
            Genes::of(text);
        }
        assert_eq!(Genes::of("f(1"), Genes::default());
    }

    #[test]
    fn kin_have_the_same_arguments() {
        let kin = Kin::new(&super::super::reference());
        let of = |full: &str, arity: usize| kin.of(full, arity).to_vec();
        assert!(of("min", 2).contains(&"max".to_owned()));
        assert!(of("sphere", 1).contains(&"octahedron".to_owned()));
        assert!(of("fractal::fbm", 2).contains(&"ridged".to_owned()));
        assert!(of("gradient", 1).iter().any(|name| name != "gradient"));
        assert!(of("union", 2).contains(&"difference".to_owned()));
        assert!(of("nobody", 1).is_empty() && !of("min", 2).contains(&"min".to_owned()));
    }
}
