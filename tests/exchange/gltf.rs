//! glTF files as other programs write them, and ours as others read them.

use crate::{fault, lump, surface, written};
use glam::DVec3;
use orogen::exchange::mesh::{self, Format, Gloss};
use serde_json::{Value, json};
use std::f64::consts::FRAC_1_SQRT_2;

/// A binary file of a text and bytes.
pub fn glb(text: &Value, bytes: &[u8]) -> Vec<u8> {
    let mut text = text.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let word = |x: usize| (x as u32).to_le_bytes();
    let parts: [&[u8]; 8] = [
        b"glTF\x02\0\0\0",
        &word(28 + text.len() + bytes.len()),
        &word(text.len()),
        b"JSON",
        &text,
        &word(bytes.len()),
        b"BIN\0",
        bytes,
    ];
    parts.concat()
}

/// Five points in the plane `z = 0` with normals, byte colours and byte corners, in one strided part.
pub fn bytes() -> Vec<u8> {
    let points: [[f32; 2]; 5] = [[0., 0.], [1., 0.], [0., 1.], [1., 1.], [0., 2.]];
    let mut bytes = Vec::new();
    for (i, [x, y]) in points.into_iter().enumerate() {
        [x, y, 0.0, 0.0, 0.0, 2.0].into_iter().for_each(|v: f32| bytes.extend(v.to_le_bytes()));
        bytes.extend([255, 0, 51 * i as u8, 7]);
    }
    bytes.extend([0, 1, 2, 3, 4, 0, 0, 0]);
    bytes
}

/// A scene of a triangle, a strip and a fan that share their points.
pub fn scene() -> Value {
    let attributes = json!({ "POSITION": 0, "NORMAL": 1, "COLOR_0": 2, "TEXCOORD_0": 99 });
    json!({
        "asset": { "version": "2.0", "copyright": "nobody" },
        "scene": 1,
        "scenes": [{}, { "nodes": [1, 0] }],
        "nodes": [
            { "mesh": 0, "children": [2], "translation": [10, 0, 0] },
            { "name": "light" },
            { "mesh": 1, "scale": [-1, 1, 2], "rotation": [0, 0, FRAC_1_SQRT_2, FRAC_1_SQRT_2] },
        ],
        "meshes": [
            { "primitives": [
                { "attributes": attributes, "mode": 1 },
                { "attributes": attributes, "indices": 3, "mode": 5 },
                { "attributes": attributes, "indices": 3, "mode": 6 },
            ] },
            { "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 } }] },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 5 },
            { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 5, "byteOffset": 12 },
            { "bufferView": 0, "componentType": 5121, "type": "VEC4", "count": 5, "byteOffset": 24, "normalized": true },
            { "bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 5 },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 140, "byteStride": 28 },
            { "buffer": 0, "byteLength": 5, "byteOffset": 140 },
        ],
        "buffers": [{ "byteLength": 145 }],
    })
}

#[test]
fn parts_are_joined_in_their_places() {
    let mesh = mesh::read("a.glb", &glb(&scene(), &bytes())).unwrap();
    // The strip and the fan share their points.
    assert_eq!(mesh.points.len(), 10);
    assert_eq!(mesh.triangles[..6], [[0, 1, 2], [1, 3, 2], [2, 3, 4], [1, 2, 0], [2, 3, 0], [3, 4, 0]]);
    assert!(mesh.normals.iter().all(|n| (n - DVec3::Z).length() < 1e-15), "{:?}", mesh.normals);
    assert_eq!(mesh.colors[1], [1.0, 0.0, 51.0 / 255.0]);
    assert_eq!(mesh.colors[9], [1.0; 3]);
    // Mirrored, then a quarter turn, then moved; still counter-clockwise about its normal.
    assert_eq!(mesh.triangles[6], [5, 7, 6]);
    let moved = [[10., 0., 0.], [9., 0., 0.], [10., -1., 0.]].map(DVec3::from);
    let [a, b, c] = mesh.corners(6);
    assert!(
        (a - moved[0]).length() + (b - moved[1]).length() + (c - moved[2]).length() < 1e-14,
        "{a} {b} {c}"
    );
    assert!((b - a).cross(c - a).z > 0.0);
}

#[test]
fn text_files_hold_their_data_or_are_refused() {
    let mut text = scene();
    use std::fmt::Write;
    let mut base64 = String::from("data:application/octet-stream;base64,");
    let digits: Vec<char> = ('A'..='Z').chain('a'..='z').chain('0'..='9').chain(['+', '/']).collect();
    for three in bytes().chunks(3) {
        let all = three.iter().chain(&[0, 0]).take(3).fold(0, |all, b| all << 8 | *b as usize);
        for k in 0..4 {
            let digit = if k <= three.len() { digits[all >> (18 - 6 * k) & 63] } else { '=' };
            write!(base64, "{digit}").unwrap();
        }
    }
    text["buffers"][0]["uri"] = base64.into();
    let binary = mesh::read("a.glb", &glb(&scene(), &bytes())).unwrap();
    assert_eq!(mesh::read("a.gltf", text.to_string().as_bytes()).unwrap(), binary);
    for (uri, what) in [
        ("a.bin", "buffers[0].uri: the data are in another file, \"a.bin\"; write the mesh as .glb"),
        ("data:,abc", "buffers[0].uri: the data are not written in base64"),
        ("data:;base64,!", "buffers[0].uri: the data are not in base64"),
        ("data:;base64,AAAA", "buffers[0]: the buffer has 3 bytes and not 145"),
    ] {
        text["buffers"][0]["uri"] = uri.into();
        let said = fault("a.gltf", text.to_string().as_bytes());
        assert!(said.contains(what), "{said}");
    }
}

/// What is said when a value of the scene is another.
#[track_caller]
fn with(path: &str, value: Value, what: &str) {
    let mut text = scene();
    *text.pointer_mut(path).unwrap_or_else(|| panic!("{path}")) = value;
    let said = fault("a.glb", &glb(&text, &bytes()));
    assert!(said.starts_with("a.glb, ") && said.contains(what), "{said}");
}

#[test]
fn faults_say_the_value() {
    with("/asset/version", "1.0".into(), "asset.version: this is glTF \"1.0\"");
    with("/asset", json!({}), "its JSON text: missing field `version`");
    with("/scene", 2.into(), "scene: there is no scene 2");
    with("/scenes/1/nodes/0", 9.into(), "nodes[9]: there is no such node");
    with("/nodes/0/children", json!([0]), "nodes[0]: the node is in the scene twice, or within itself");
    with("/nodes/0/children", json!([2, 2]), "nodes[2]: the node is in the scene twice");
    with("/nodes/0/mesh", 7.into(), "meshes[7]: there is no such mesh");
    with("/nodes/2/rotation", json!([0, 0, 0, 0]), "accessors[0]: point 0 is not finite in its place");
    with("/meshes/1/primitives/0/attributes", json!({}), "meshes[1].primitives[0]: the part has no POSITION");
    with("/meshes/0/primitives/1/indices", 4.into(), "accessors[4]: there is no such accessor");
    with("/meshes/0/primitives/1/indices", 2.into(), "accessors[2]: the accessor holds items \"VEC4\"");
    with(
        "/meshes/1/primitives/0/attributes/POSITION",
        3.into(),
        "accessors[3]: the accessor holds items \"SCALAR\"",
    );
    with("/accessors/3/componentType", 5126.into(), "accessors[3]: 5 items leave the 5 bytes");
    with("/accessors/3/componentType", 0.into(), "accessors[3]: 0 is no type of components");
    with("/accessors/0/count", 0.into(), "accessors[0]: 0 items");
    with("/accessors/0/count", 6.into(), "accessors[0]: 6 items leave the 140 bytes");
    with("/accessors/0/count", 4_000_000_000_u64.into(), "accessors[0]: 4000000000 items");
    with("/accessors/0/count", u64::MAX.into(), "accessors[0]: 18446744073709551615 items");
    with("/accessors/0/count", (-1).into(), "its JSON text: invalid value");
    with("/accessors/1/count", 4.into(), "accessors[1]: there are 4 items for 5 points");
    with("/accessors/1/byteOffset", u64::MAX.into(), "accessors[1]: 5 items leave");
    with("/bufferViews/0/byteStride", 8.into(), "accessors[0]: items of 12 bytes are 8 bytes apart");
    with("/bufferViews/0/byteStride", u64::MAX.into(), "accessors[0]: 5 items leave");
    with("/bufferViews/0/byteLength", 999.into(), "bufferViews[0]: it leaves the 148 bytes");
    with("/bufferViews/0/buffer", 1.into(), "bufferViews[0]: there is no such buffer");
    with("/bufferViews/1/byteOffset", u64::MAX.into(), "bufferViews[1]: it leaves");
    with("/buffers/0/byteLength", 160.into(), "buffers[0]: the buffer has 148 bytes and not 160");
    let mut text = scene();
    text["extensionsRequired"] = json!(["KHR_materials_unlit", "KHR_draco_mesh_compression"]);
    assert!(fault("a.glb", &glb(&text, &bytes())).contains("without compression, if it is that"));
    text = scene();
    text["accessors"][0]["sparse"] = json!({ "count": 1 });
    assert!(fault("a.glb", &glb(&text, &bytes())).contains("accessors[0]: sparse accessors are not read"));
    let mut out_of_range = bytes();
    out_of_range[141] = 5;
    assert!(
        fault("a.glb", &glb(&scene(), &out_of_range))
            .contains("meshes[0].primitives[1].indices: corner 1 is none of the 5 points")
    );
}

#[test]
fn containers_are_checked() {
    let whole = glb(&scene(), &bytes());
    let with = |at: usize, byte: u8| {
        let mut bytes = whole.clone();
        bytes[at] = byte;
        fault("a.glb", &bytes)
    };
    assert!(with(4, 1).contains("byte 4: this is version 1"));
    assert!(with(11, 255).contains("byte 8: the file has"));
    assert!(with(15, 255).contains("byte 12: a part of the file leaves the file"));
    assert!(with(16, 0).contains("byte 16: the file does not begin with its JSON text"));
    let second = whole.len() - bytes().len() - 8;
    assert!(with(second + 3, 255).contains(&format!("byte {second}: a part of the file leaves")));
    assert!(with(second + 4, 0).contains("buffers[0]: the buffer has no data"));
    assert!(fault("a.glb", b"glTF\x02\0\0\0").contains("ends in its header"));
}

#[test]
fn deep_nesting_and_repetition_have_limits() {
    let n = 30_000;
    // A chain of nodes is no problem.
    let mut text = scene();
    text["nodes"] = (0..n).map(|i| json!({ "children": [i + 1] })).chain([json!({ "mesh": 1 })]).collect();
    text["scenes"][1]["nodes"] = json!([0]);
    assert_eq!(mesh::read("a.glb", &glb(&text, &bytes())).unwrap().triangles.len(), 1);
    // Brackets within brackets are.
    let deep = "[".repeat(n);
    assert!(fault("a.gltf", format!("{{\"asset\":{deep}").as_bytes()).contains("its JSON text"));
    assert!(
        fault("a.gltf", format!("{{\"asset\":{{\"version\":\"2.0\"}},\"extras\":{deep}").as_bytes())
            .contains("its JSON text")
    );
    assert!(fault("a.gltf", format!("{{\"nodes\":{deep}").as_bytes()).contains("its JSON text"));
    // Many nodes of one mesh of many points.
    let points = vec![0; 12 * n];
    text["buffers"][0]["byteLength"] = points.len().into();
    text["bufferViews"] = json!([{ "buffer": 0, "byteLength": points.len() }]);
    text["accessors"] = json!([{ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": n }]);
    text["meshes"] = json!([{ "primitives": [{ "attributes": { "POSITION": 0 } }] }]);
    text["nodes"] = vec![json!({ "mesh": 0 }); n].into();
    text["scenes"] = json!([{ "nodes": (0..n).collect::<Vec<_>>() }]);
    text["scene"] = 0.into();
    assert!(fault("a.glb", &glb(&text, &points)).contains("the scene repeats its meshes so often"));
}

#[test]
fn what_is_glossy_is_so_in_another_program() {
    let read = |gloss: Gloss| {
        let mut bytes = Vec::new();
        mesh::write_glossy(Format::Glb, &lump(2), &gloss, &mut bytes).unwrap();
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        gltf::Gltf::from_slice_without_validation(&bytes).unwrap();
        serde_json::from_slice::<Value>(&bytes[20..20 + length]).unwrap()
    };
    let matt = read(Gloss::default());
    assert_eq!(
        matt["materials"],
        json!([{ "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 } }])
    );
    assert_eq!(matt["extensionsUsed"], Value::Null);
    let gold = read(Gloss { metal: 1.0, roughness: 0.25, light: [0.5, 0.25, 0.0], ..Gloss::default() });
    assert_eq!(
        gold["materials"],
        json!([{
            "pbrMetallicRoughness": { "metallicFactor": 1.0, "roughnessFactor": 0.25 },
            "emissiveFactor": [0.5, 0.25, 0.0],
        }])
    );
    let lamp = read(Gloss { coat: 0.5, roughness: 0.1, light: [8.0, 4.0, 0.0], ..Gloss::default() });
    let material = &lamp["materials"][0];
    assert_eq!(lamp["extensionsUsed"], json!(["KHR_materials_clearcoat", "KHR_materials_emissive_strength"]));
    assert_eq!(material["pbrMetallicRoughness"]["roughnessFactor"], 1.0);
    assert_eq!(material["emissiveFactor"], json!([1.0, 0.5, 0.0]));
    assert_eq!(material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"], 8.0);
    let coat = &material["extensions"]["KHR_materials_clearcoat"];
    assert_eq!(
        (coat["clearcoatFactor"].as_f64(), coat["clearcoatRoughnessFactor"].as_f64()),
        (Some(0.5), Some(0.1))
    );
}

#[test]
fn another_reader_agrees() {
    for (n, width) in [(3, gltf::accessor::DataType::U16), (110, gltf::accessor::DataType::U32)] {
        let mesh = lump(n);
        let bytes = written(Format::Glb, &mesh);
        // This checks the text against the standard.
        let file = gltf::Gltf::from_slice(&bytes).unwrap();
        let part = file.meshes().next().unwrap().primitives().next().unwrap();
        assert_eq!(part.indices().unwrap().data_type(), width);
        let reader = part.reader(|_| file.blob.as_deref());
        let points: Vec<DVec3> = reader.read_positions().unwrap().map(|p| p.map(f64::from).into()).collect();
        let corners: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert_eq!(points, mesh.points);
        assert_eq!(corners, mesh.triangles.as_flattened());
        let normals: Vec<[f32; 3]> = reader.read_normals().unwrap().collect();
        assert_eq!(normals, mesh.normals.iter().map(|n| n.as_vec3().to_array()).collect::<Vec<_>>());
        let colors: Vec<[f32; 3]> = reader.read_colors(0).unwrap().into_rgb_f32().collect();
        assert_eq!(colors, mesh.colors);
        let (least, most) = mesh.bounds().unwrap();
        let bounds = part.bounding_box();
        assert_eq!([bounds.min, bounds.max].map(|p| DVec3::from(p.map(f64::from))), [least, most]);
    }
}

#[test]
fn what_the_standard_wants_is_written() {
    let mut mesh = lump(2);
    mesh.colors[0] = [-1.0, 0.5, 7.0];
    mesh.normals[0] *= 3.0;
    let back = mesh::read("a.glb", &written(Format::Glb, &mesh)).unwrap();
    assert_eq!(back.colors[0], [0.0, 0.5, 1.0]);
    assert!((back.normals[0].length() - 1.0).abs() < 1e-7);
    mesh.normals[0] = DVec3::ZERO;
    assert_eq!(mesh::read("a.glb", &written(Format::Glb, &mesh)).unwrap().normals, []);
    mesh.triangles.clear();
    assert!(fault("a.glb", &written(Format::Glb, &mesh)).contains("the file holds no triangles"));
    assert!(surface(&mesh).is_empty());
    let mut far = lump(1);
    far.points[0].x = 1e39;
    let error = mesh::write(Format::Glb, &far, &mut Vec::new()).unwrap_err().to_string();
    assert!(error.starts_with("glTF holds coordinates in 32 bits"), "{error}");
}
