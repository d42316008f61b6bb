//! Options in object maps: each is declared where it is read, and a key that nobody declared is an
//! error that names the nearest one that was.
//!
//! Where a number is wanted, a function of time alone is one too: what it is at the time of the run.

use super::fault::{Fault, Outcome};
use super::library::Call;
use super::value::{Field, Value, Vec3, VectorField, number, type_name};
use crate::diag;
use crate::expr::NodeId;
use crate::noise::{Allowed, Parameter, Setting};
use glam::DVec3;
use rhai::{Array, Dynamic, INT, Map};
use std::ops::RangeInclusive;

/// The options of one call, as they are read.
pub struct Options<'a, 'b> {
    call: &'a Call<'b>,
    map: Map,
    known: Vec<&'static str>,
}

impl<'a, 'b> Options<'a, 'b> {
    /// The object map that is argument `i`.
    pub fn new(call: &'a Call<'b>, i: usize) -> Outcome<Self> {
        let map = call.args[i].read_lock::<Map>().map(|map| map.clone());
        let map = map.ok_or_else(|| call.wrong(i, "an object map, #{ ... }"))?;
        Ok(Options { call, map, known: Vec::new() })
    }

    /// The value of a key, if it is given.
    pub fn get(&mut self, key: &'static str) -> Option<Dynamic> {
        if !self.known.contains(&key) {
            self.known.push(key);
        }
        self.map.get(key).map(Dynamic::flatten_clone)
    }

    fn wrong(&self, key: &str, wanted: &str, given: &Dynamic) -> Fault {
        Fault::new(format!("`{key}` of `{}` must be {wanted}, not {}", self.call.name, describe(given)))
            .key(key)
            .label(format!("{wanted} expected"))
    }

    fn outside<T: std::fmt::Debug>(&self, key: &str, given: T, range: &RangeInclusive<T>) -> Fault {
        Fault::new(format!("`{key}` of `{}` is out of range: {given:?}", self.call.name))
            .key(key)
            .label(format!("from {:?} to {:?} allowed", range.start(), range.end()))
    }

    /// The value with numbers in place of functions of time alone, as they are at the time of the run.
    ///
    /// # Errors
    /// If such a function also depends on the place.
    pub fn still(&self, key: &str, wanted: &str, given: &Dynamic) -> Outcome<Dynamic> {
        let now = |node: NodeId| {
            let host = self.call.host;
            if let Some(now) = host.now(node)? {
                return Ok(now);
            }
            let places = host.places(node);
            let message = format!(
                "`{key}` of `{}` must be {wanted}, not a field of {}",
                self.call.name,
                places.join(", ")
            );
            let fault = Fault::new(message).key(key).label(format!("{wanted} expected"));
            Err(fault.hint("functions of time alone are possible, such as 10.0 * time"))
        };
        if let Some(field) = given.read_lock::<Field>() {
            return now(field.node).map(Dynamic::from_float);
        }
        if let Some(VectorField([x, y, z])) = given.read_lock::<VectorField>().map(|v| *v) {
            return Ok(Dynamic::from(Vec3([now(x)?, now(y)?, now(z)?])));
        }
        let Some(list) = given.read_lock::<Array>().map(|list| list.clone()) else {
            return Ok(given.clone());
        };
        let entry = |v: Dynamic| match v.read_lock::<Field>().map(|field| field.node) {
            Some(node) => now(node).map(Dynamic::from_float),
            None => Ok(v),
        };
        list.into_iter().map(entry).collect::<Outcome<Array>>().map(Dynamic::from)
    }

    /// A value as arithmetic knows it, if it does.
    pub fn value(&self, given: &Dynamic) -> Outcome<Option<Value>> {
        Value::of(self.call.host, given)
    }

    /// A number within a range.
    pub fn number(&mut self, key: &'static str, range: RangeInclusive<f64>, default: f64) -> Outcome<f64> {
        let Some(given) = self.get(key) else { return Ok(default) };
        let given = self.still(key, "a number", &given)?;
        let value = number(&given).ok_or_else(|| self.wrong(key, "a number", &given))?;
        if range.contains(&value) { Ok(value) } else { Err(self.outside(key, value, &range)) }
    }

    /// A whole number within a range.
    pub fn integer(&mut self, key: &'static str, range: RangeInclusive<INT>, default: INT) -> Outcome<INT> {
        let Some(given) = self.get(key) else { return Ok(default) };
        let given = self.still(key, "a whole number", &given)?;
        let whole = number(&given).filter(|v| v.fract() == 0.0 && v.abs() < 9e15);
        let value = whole.ok_or_else(|| self.wrong(key, "a whole number", &given))? as INT;
        if range.contains(&value) { Ok(value) } else { Err(self.outside(key, value, &range)) }
    }

    /// A switch.
    pub fn flag(&mut self, key: &'static str, default: bool) -> Outcome<bool> {
        let Some(given) = self.get(key) else { return Ok(default) };
        given.as_bool().map_err(|_| self.wrong(key, "true or false", &given))
    }

    /// How much there is of something: a number within a range, true for 1, false for 0; 0 unless given.
    pub fn amount(&mut self, key: &'static str, range: RangeInclusive<f64>) -> Outcome<f64> {
        match self.get(key).map(|given| given.as_bool()) {
            Some(Ok(there)) => Ok(f64::from(there)),
            _ => self.number(key, range, 0.0),
        }
    }

    /// A point or direction.
    pub fn vector(&mut self, key: &'static str, default: DVec3) -> Outcome<DVec3> {
        let wanted = "a vector such as vec3(0, 1, 0) or [0, 1, 0]";
        let Some(given) = self.get(key) else { return Ok(default) };
        let given = self.still(key, wanted, &given)?;
        let found = self.call.vec3_of(&given)?.filter(|v| v.is_finite());
        found.ok_or_else(|| self.wrong(key, wanted, &given))
    }

    /// A number by channel, each within a range: a vector, or one number for all.
    pub fn channels(
        &mut self,
        key: &'static str,
        range: RangeInclusive<f64>,
        default: DVec3,
    ) -> Outcome<DVec3> {
        let Some(given) = self.get(key) else { return Ok(default) };
        let each = match number(&given) {
            Some(one) => DVec3::splat(one),
            None => self.vector(key, default)?,
        };
        match each.to_array().into_iter().find(|v| !range.contains(v)) {
            Some(value) => Err(self.outside(key, value, &range)),
            None => Ok(each),
        }
    }

    /// A direction, which has a length.
    pub fn direction(&mut self, key: &'static str, default: DVec3) -> Outcome<DVec3> {
        let v = self.vector(key, default)?;
        v.try_normalize().ok_or_else(|| {
            Fault::new(format!("`{key}` of `{}` has no direction: its length is zero", self.call.name))
                .key(key)
        })
    }

    /// A colour: a vector, a grey, or a text such as "#ff8800"; not negative.
    pub fn color(&mut self, key: &'static str, default: DVec3) -> Outcome<DVec3> {
        let Some(given) = self.get(key) else { return Ok(default) };
        let wanted = "a colour such as \"#ff8800\", rgb(1.0, 0.5, 0.0) or 0.5";
        let given = self.still(key, wanted, &given)?;
        let color = match self.call.constant_color(&given) {
            Ok(color) => color,
            Err(fault) => return Err(fault.key(key)),
        };
        let color = color.filter(|c| c.is_finite()).ok_or_else(|| self.wrong(key, wanted, &given))?;
        self.positive(key, color)
    }

    /// A colour that is no less than black, and finite.
    pub fn positive(&self, key: &str, color: DVec3) -> Outcome<DVec3> {
        if color.is_finite() && color.min_element() >= 0.0 {
            return Ok(color);
        }
        let [r, g, b] = color.to_array();
        let name = &self.call.name;
        let what = if color.is_finite() { "less than nothing" } else { "not finite" };
        let fault = Fault::new(format!("`{key}` of `{name}` is {what}: {r:?}, {g:?}, {b:?}"));
        Err(fault.key(key).label("numbers from 0 on allowed"))
    }

    /// A share: a number from 0 to 1, or a field.
    pub fn share(&mut self, key: &'static str, default: f64) -> Outcome<NodeId> {
        match self.get(key) {
            Some(given) if number(&given).is_none() => Ok(self.field(key)?.node),
            _ => {
                let share = self.number(key, 0.0..=1.0, default)?;
                self.call.host.constant(share)
            }
        }
    }

    /// A value that is not one of the plain kinds, for a caller that tells them apart.
    pub fn mismatch(&self, key: &str, wanted: &str, given: &Dynamic) -> Fault {
        self.wrong(key, wanted, given)
    }

    /// The value of a noise's parameter.
    pub fn setting(&mut self, p: &Parameter) -> Outcome<Setting> {
        let name = p.name;
        Ok(match p.allowed {
            Allowed::Number { least, most, default } => {
                Setting::Number(self.number(name, least..=most, default)?)
            }
            Allowed::Whole { least, most, default } => {
                let whole = self.integer(name, INT::from(least)..=INT::from(most), INT::from(default))?;
                Setting::Number(whole as f64)
            }
            Allowed::Choice(names) => Setting::Name(self.choice(name, names)?),
            Allowed::Flag { default } => Setting::Flag(self.flag(name, default)?),
            Allowed::Direction => {
                let given = self.map.contains_key(name);
                let direction = self.direction(name, DVec3::Y)?;
                Setting::Direction(given.then(|| direction.to_array()))
            }
            Allowed::Numbers { most, default } => Setting::Numbers(self.numbers(name, most, default)?),
        })
    }

    /// One of some names; the first unless given.
    pub fn choice(&mut self, key: &'static str, names: &[&'static str]) -> Outcome<&'static str> {
        let first = names.first().copied().unwrap_or_default();
        let Some(given) = self.get(key) else { return Ok(first) };
        let wanted =
            format!("one of {}", names.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", "));
        let text = given.clone().into_string().map_err(|_| self.wrong(key, &wanted, &given))?;
        names.iter().copied().find(|n| *n == text).ok_or_else(|| {
            let fault = self.wrong(key, &wanted, &given);
            match diag::nearest(&text, names.iter().copied()) {
                Some(near) => fault.hint(format!("did you mean \"{near}\"?")),
                None => fault,
            }
        })
    }

    /// One to four numbers, the rest of which are zero.
    fn numbers(&mut self, key: &'static str, most: f64, default: [f64; 4]) -> Outcome<[f64; 4]> {
        let Some(given) = self.get(key) else { return Ok(default) };
        let wrong = || self.wrong(key, &format!("one to four numbers from {} to {most}", -most), &given);
        let list = given.read_lock::<Array>().map(|a| a.clone()).ok_or_else(wrong)?;
        if list.is_empty() || list.len() > 4 {
            return Err(wrong());
        }
        let found = entries(key, &list, |v| number(v).filter(|v| v.abs() <= most), wrong)?;
        let mut out = [0.0; 4];
        out.iter_mut().zip(found).for_each(|(out, v)| *out = v);
        Ok(out)
    }

    /// A value of a type of our own.
    pub fn typed<T: Clone + 'static>(&mut self, key: &'static str, wanted: &str, default: T) -> Outcome<T> {
        let Some(given) = self.get(key) else { return Ok(default) };
        given.read_lock::<T>().map(|v| v.clone()).ok_or_else(|| self.wrong(key, wanted, &given))
    }

    /// The same, if it is given.
    pub fn given<T: Clone + 'static>(&mut self, key: &'static str, wanted: &str) -> Outcome<Option<T>> {
        let Some(given) = self.get(key) else { return Ok(None) };
        let found = given.read_lock::<T>().map(|v| v.clone());
        found.map(Some).ok_or_else(|| self.wrong(key, wanted, &given))
    }

    /// A field, which must be given.
    pub fn field(&mut self, key: &'static str) -> Outcome<Field> {
        let given = self.get(key).ok_or_else(|| self.missing(key))?;
        self.call.field_of(&given)?.ok_or_else(|| self.wrong(key, "a field", &given))
    }

    /// Ends with an error for a key that must be there.
    pub fn missing(&self, key: &str) -> Fault {
        let fault = Fault::new(format!("`{}` needs the option `{key}`", self.call.name));
        let unread = self.map.keys().map(|k| k.as_str()).filter(|k| !self.known.contains(k));
        match unread.into_iter().find(|given| diag::nearest(given, [key]).is_some()) {
            Some(given) => fault.key(given).label(format!("did you mean `{key}`?")),
            None => fault,
        }
    }

    /// Refuses keys that nobody asked for.
    pub fn finish(self) -> Outcome<()> {
        let Some(key) = self.map.keys().find(|key| !self.known.contains(&key.as_str())) else {
            return Ok(());
        };
        Err(no_option(self.call.name, key, &self.known))
    }
}

/// A function has no option of this name, but those.
fn no_option(function: &str, key: &str, known: &[&str]) -> Fault {
    let fault = Fault::new(format!("`{function}` has no option `{key}`")).key(key).label("unknown option");
    let fault = match diag::nearest(key, known.iter().copied()) {
        Some(near) => fault.hint(format!("did you mean `{near}`?")),
        None => fault,
    };
    fault.hint(format!("its options are {}", known.join(", ")))
}

/// What a script says that is wrong with an option: an object map with its `key`, and either the `message`, or the name of
/// the function `of` which it is none, that has the `known` ones.
pub fn thrown(map: &Map) -> Option<Fault> {
    let text = |v: &Dynamic| v.clone().into_string().ok();
    let key = text(map.get("key")?)?;
    if let Some(message) = map.get("message").and_then(text) {
        return Some(Fault::new(message).key(&key));
    }
    let known = map.get("known")?.read_lock::<Array>()?.iter().filter_map(text).collect::<Vec<String>>();
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    Some(no_option(&text(map.get("of")?)?, &key, &known))
}

/// The entries of an array that is an option, or what is wrong with the option and which entry is to
/// blame.
pub fn entries<T>(
    key: &str,
    list: &[Dynamic],
    read: impl Fn(&Dynamic) -> Option<T>,
    wrong: impl Fn() -> Fault,
) -> Outcome<Vec<T>> {
    let entry = |(i, v): (usize, &Dynamic)| {
        read(v).ok_or_else(|| wrong().hint(format!("{key}[{i}] is {}", describe(v))))
    };
    list.iter().enumerate().map(entry).collect()
}

/// A value for a message: its type, and the value itself where that is short.
pub fn describe(v: &Dynamic) -> String {
    let name = type_name(v);
    match name {
        "nothing" => "nothing ()".to_owned(),
        "integer" | "float" | "boolean" => format!("{} ({v})", with_article(name)),
        "string" => {
            let text: String = v.to_string().chars().take(20).collect();
            format!("a string ({text:?})")
        }
        "array" => format!("an array of {}", v.read_lock::<Array>().map_or(0, |a| a.len())),
        _ => with_article(name),
    }
}

/// "a Field", "an Interval".
pub fn with_article(name: &str) -> String {
    let vowel = name.starts_with(['a', 'e', 'i', 'o', 'A', 'E', 'I', 'O']);
    format!("{} {name}", if vowel { "an" } else { "a" })
}
