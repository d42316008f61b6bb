//! Messages of the script engine, in the words of scripts.

use super::marks::plain;

/// A text that goes on in a sentence: its first letter small, unless it begins with capitals.
pub(super) fn lower_first(text: &str) -> String {
    let mut chars = text.chars();
    let acronym = text.chars().nth(1).is_some_and(char::is_uppercase);
    match chars.next() {
        Some(c) if !acronym => c.to_lowercase().chain(chars).collect(),
        _ => text.to_owned(),
    }
}

/// What a function is called in messages.
pub(super) fn function_name(name: &str) -> String {
    if name.starts_with("anon$") { "a function without a name".to_owned() } else { plain(name) }
}

/// A message without the place that the engine ends it with.
pub(super) fn without_position(text: &str) -> String {
    text.split(" (line ").next().unwrap_or(text).to_owned()
}

/// Names of types in an engine's message, as scripts have them.
pub(super) fn type_text(text: &str) -> String {
    let mut out = plain(text);
    let pairs = [
        ("&str | ImmutableString | String", "string"),
        ("ImmutableString", "string"),
        ("rhai::FnPtr", "function"),
        ("FnPtr", "function"),
        ("i64", "integer"),
        ("f64", "float"),
        ("()", "nothing"),
        ("#{}", "object map"),
        ("floating-point number", "float"),
    ];
    for (from, to) in pairs {
        out = out.replace(from, to);
    }
    // Whatever path is left names a type of the host.
    out.split(' ').map(own_name).collect::<Vec<_>>().join(" ")
}

/// The name that scripts have for a type of the host.
fn own_name(word: &str) -> &str {
    let Some((_, last)) = word.rsplit_once("::") else { return word };
    if !(word.starts_with("orogen::")
        || word.contains('<')
        || word.starts_with("core::")
        || word.starts_with("alloc::"))
    {
        return word;
    }
    match last.trim_end_matches(['>', ',', ')']) {
        "SceneValue" => "Scene",
        "Source" => "Noise",
        name @ ("Field" | "VectorField" | "Vec3" | "Region" | "AffineVec3" | "Interval" | "Affine") => name,
        name @ ("Camera" | "Sun" | "Sky" | "Film" | "Air") => name,
        _ => "value",
    }
}
