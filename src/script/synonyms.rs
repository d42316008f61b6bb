//! What other tools call things that have another name here.

/// Names of functions elsewhere, and what to write here.
const FUNCTIONS: &[(&[&str], &str)] = &[
    (&["cube", "cuboid"], "box(size)"),
    (&["ball"], "sphere(radius)"),
    (&["circle"], "disc(radius, thickness) is round and flat"),
    (&["hexagon", "regular_polygon"], "prism(sides, radius, height)"),
    (&["halfspace", "half_space"], "plane(normal, offset)"),
    (&["subtract", "subtraction", "minus", "cut"], "difference(a, b)"),
    (&["intersect"], "intersection(a, b)"),
    (&["add", "join", "fuse", "combine"], "union(a, b)"),
    (&["smin", "smooth_min", "smoothmin", "blend", "soft_union"], "smooth_union(a, b, radius)"),
    (&["smax", "smooth_max", "smoothmax"], "smooth_intersection(a, b, radius)"),
    (&["hull", "convex_hull"], "convex_polygon(corners) is the hull of points in the plane"),
    (&["minkowski", "dilate", "grow", "inflate"], "offset(a, distance)"),
    (&["hollow", "thicken", "onion"], "shell(a, thickness)"),
    (&["invert", "inverse"], "complement(a), or -a"),
    (&["move", "moved", "shift", "shifted"], "f.translated([x, y, z])"),
    (&["turn", "turned", "rotate_x", "rotated_x"], "f.rotated([1, 0, 0], degrees)"),
    (&["rotate_y", "rotated_y"], "f.rotated([0, 1, 0], degrees)"),
    (&["rotate_z", "rotated_z"], "f.rotated([0, 0, 1], degrees)"),
    (&["resize", "resized", "zoom"], "f.scaled(factor)"),
    (&["mirror", "reflect", "reflected"], "f.mirrored(normal)"),
    (&["lerp"], "mix(a, b, t)"),
    (&["saturate"], "clamp(x, 0.0, 1.0)"),
    (&["mod", "fmod", "rem"], "modulo(x, period)"),
    (&["log", "log_e"], "ln(x)"),
    (&["ceil"], "-floor(-x)"),
    (&["sq", "sqr"], "square(x)"),
    (&["deg_to_rad", "to_radians"], "radians(degrees); functions that turn things take degrees as they are"),
    (&["normalise", "normalized", "unit"], "normalize(v)"),
    (&["vec", "vector", "point"], "vec3(x, y, z)"),
    (&["color", "colour", "hsv", "hsl"], "rgb(red, green, blue), from 0 to 1, or rgb(\"#ff8000\")"),
    (&["paint", "with_color"], "f.colored(color)"),
    (&["noise", "perlin", "perlin_noise", "gradient_noise"], "gradient(seed)"),
    (&["simplex_noise", "snoise"], "simplex(seed)"),
    (&["worley", "voronoi", "cellular_noise"], "cellular(seed)"),
    (&["value_noise"], "value(seed)"),
    (&["freq", "frequency"], "noise.scaled(factor); 2.0 makes noises twice as fine"),
    (
        &["rand", "random", "hash"],
        "a noise, such as value(seed).at([i, 0, 0]), from -1 to 1 for each whole number: scripts have no chance in them",
    ),
    (
        &["linear_extrude", "extrude"],
        "import \"std/arrange\" as arrange; then arrange::extrude(profile, length)",
    ),
    (
        &["rotate_extrude", "lathe", "revolve"],
        "import \"std/arrange\" as arrange; then arrange::revolve(profile)",
    ),
    (&["array", "linear_array"], "import \"std/arrange\" as arrange; then arrange::row(f, step, count)"),
    (
        &["polar_array", "circular_pattern"],
        "import \"std/arrange\" as arrange; then arrange::around(f, count)",
    ),
    (&["repeated", "tile"], "import \"std/arrange\" as arrange; then arrange::repeat(f, cell)"),
    (&["displace", "displaced"], "f - height * noise, or import \"std/displace\" as displace;"),
    (&["bend"], "import \"std/deform\" as deform; then deform::bend(f, degrees, from, to)"),
    (&["wrap", "wrapped"], "import \"std/deform\" as deform; then deform::wrap(f, radius)"),
    (&["engrave", "emboss"], "text(string) for letters, then difference(f, letters) or union(f, letters)"),
    (&["checkerboard", "chequer", "chess"], "import \"std/pattern\" as pattern; then pattern::checker(size)"),
    (&["brick"], "import \"std/pattern\" as pattern; then pattern::bricks(u, v, length, height)"),
    (&["wood"], "import \"std/pattern\" as pattern; then pattern::rings(value, spacing)"),
    (&["marble"], "import \"std/pattern\" as pattern; then pattern::veins(f, width)"),
    (&["loft"], "import \"std/morph\" as morph; then morph::between(a, b, clamp(y, 0.0, 1.0))"),
    (&["morph"], "import \"std/morph\" as morph; then morph::between(a, b, share)"),
    (&["warp", "warped"], "import \"std/warp\" as warp; then warp::by_noise(f, noise, amount)"),
    (&["camera"], "orbit(#{ distance: 4.0 }) or look_at(#{ eye: [0, 0, 4] })"),
    (&["light", "point_light"], "lamp(#{ position: [2, 3, 2] }) or sun(#{ azimuth: 60.0 })"),
];

/// What to write for a function that other tools have.
pub fn function(name: &str) -> Option<&'static str> {
    FUNCTIONS.iter().find(|(names, _)| names.contains(&name)).map(|(_, here)| *here)
}

/// What to write for an operator that has no meaning here, or not for such things.
pub fn operator(name: &str, given: &str) -> Option<&'static str> {
    match name {
        "^" => Some("powers are written with two stars: x ** 2"),
        "|" | "||" => Some("union(a, b) is what is inside either solid"),
        "&" | "&&" => Some("intersection(a, b) is what is inside both solids"),
        "!" | "~" => Some("complement(a), or -a, is what is outside of a solid"),
        "+" | "-" | "*" | "/" if given.contains("array") => {
            Some("vec3(x, y, z) is a vector that can be computed with")
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    /// No name is that of a function that there is, in which case its own errors say more, and none is there twice.
    #[test]
    fn names_are_those_of_others() {
        let here: HashSet<String> = crate::script::reference().into_iter().map(|entry| entry.name).collect();
        let all: Vec<&str> = FUNCTIONS.iter().flat_map(|(names, _)| names.iter().copied()).collect();
        assert_eq!(all.iter().collect::<HashSet<_>>().len(), all.len());
        let taken: Vec<&&str> = all.iter().filter(|name| here.contains(**name)).collect();
        assert!(taken.is_empty(), "{taken:?}");
        // What is to be written instead is there.
        for (_, text) in FUNCTIONS {
            let calls = text.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':' || c == '('));
            let names = calls.filter_map(|call| call.split_once('(')).map(|(name, _)| name);
            let names: Vec<&str> = names.filter(|name| !name.is_empty()).collect();
            assert!(names.iter().all(|name| here.contains(*name)), "{text}: {names:?}");
        }
    }
}
