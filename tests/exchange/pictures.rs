//! Pictures as arrays of numbers, and volumes.

use crate::memory::peak;
use exr::prelude::*;
use orogen::exchange::image::{self, Image as Numbers};
use orogen::exchange::{Fault, grid};
use orogen::grid::{Edge, Frame, Samples};
use png::{BitDepth, ColorType};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use std::io::Cursor;

const MOST: usize = 1 << 20;

fn png(size: [u32; 2], color: ColorType, depth: BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if color == ColorType::Indexed {
        encoder.set_palette(vec![0, 0, 0, 255, 255, 255, 0, 255, 0]);
    }
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    bytes
}

/// An EXR of several channels, each with a name and a number for the first of its 3 x 2 pixels.
fn exr(parts: &[(&str, &[(&str, f32)])]) -> Vec<u8> {
    let layer = |(name, channels): &(&str, &[(&str, f32)])| {
        let channel = |(name, first): &(&str, f32)| {
            AnyChannel::new(*name, FlatSamples::F32((0..6).map(|i| first + i as f32).collect()))
        };
        let channels = AnyChannels::sort(channels.iter().map(channel).collect());
        Layer::new((3, 2), LayerAttributes::named(*name), Encoding::SMALL_LOSSLESS, channels)
    };
    let layers: Vec<_> = parts.iter().map(layer).collect();
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((3, 2)));
    let mut bytes = Cursor::new(Vec::new());
    exr::image::Image::from_layers(attributes, layers).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

fn read(name: &str, bytes: &[u8], channel: Option<&str>) -> std::result::Result<Numbers, Fault> {
    image::read(name, bytes, channel, MOST)
}

fn values(name: &str, bytes: &[u8], channel: Option<&str>) -> Vec<f64> {
    read(name, bytes, channel).unwrap().values
}

fn fault(name: &str, bytes: &[u8], channel: Option<&str>) -> String {
    read(name, bytes, channel).unwrap_err().to_string()
}

#[test]
fn png_greys_go_from_zero_to_one() {
    let deep = png([3, 1], ColorType::Grayscale, BitDepth::Sixteen, &[0, 0, 1, 2, 255, 255]);
    assert_eq!(values("a.png", &deep, None), [0.0, 258.0 / 65535.0, 1.0]);
    let image = read("a.PNG", &png([2, 1], ColorType::Grayscale, BitDepth::Eight, &[51, 255]), None).unwrap();
    assert_eq!(image, Numbers { width: 2, height: 1, values: vec![0.2, 1.0] });
    let bits = png([9, 1], ColorType::Grayscale, BitDepth::One, &[0b0100_0000, 0b1000_0000]);
    assert_eq!(values("a.png", &bits, None), [0., 1., 0., 0., 0., 0., 0., 0., 1.]);
    let with_alpha = png([1, 1], ColorType::GrayscaleAlpha, BitDepth::Eight, &[51, 102]);
    assert_eq!(values("a.png", &with_alpha, None), [0.2]);
    assert_eq!(values("a.png", &with_alpha, Some("A")), [0.4]);
}

#[test]
fn png_colours_have_a_brightness_and_channels() {
    let color = png([2, 1], ColorType::Rgb, BitDepth::Eight, &[255, 0, 0, 0, 51, 255]);
    let bright = values("a.png", &color, None);
    assert_eq!(bright[0], 0.2126);
    assert!((bright[1] - 0.2 * 0.7152 - 0.0722).abs() < 1e-15);
    assert_eq!(values("a.png", &color, Some("G")), [0.0, 0.2]);
    assert!(fault("a.png", &color, Some("Z")).ends_with("no channel \"Z\"; its channels are R, G, B"));
    let deep = png([1, 1], ColorType::Rgba, BitDepth::Sixteen, &[0, 0, 255, 255, 0, 0, 0, 0]);
    assert_eq!(values("a.png", &deep, None), [0.7152]);
    let palette = png([4, 1], ColorType::Indexed, BitDepth::Two, &[0b0001_1000]);
    assert_eq!(values("a.png", &palette, None)[..3], [0.0, 0.2126 + 0.7152 + 0.0722, 0.7152]);
}

#[test]
fn exr_channels_are_found_by_name() {
    let one = exr(&[("", &[("R", 10.0), ("G", 20.0), ("normal.X", 30.0)])]);
    assert_eq!(values("a.exr", &one, None), [10., 11., 12., 13., 14., 15.]);
    assert_eq!(values("a.exr", &one, Some("normal.X"))[0], 30.0);
    assert!(fault("a.exr", &one, Some("Y")).ends_with("no channel \"Y\"; its channels are G, R, normal.X"));
    let two = exr(&[("land", &[("height", 1.0), ("R", 2.0)]), ("sea", &[("height", 3.0), ("Y", 4.0)])]);
    assert_eq!(values("a.exr", &two, None)[0], 4.0);
    assert_eq!(values("a.exr", &two, Some("height"))[0], 1.0);
    assert_eq!(values("a.exr", &two, Some("sea.height"))[0], 3.0);
    assert_eq!(values("a.exr", &exr(&[("", &[("depth", 7.0)])]), None)[0], 7.0);
    let hole = exr(&[("", &[("Z", f32::INFINITY)])]);
    assert!(fault("a.exr", &hole, None).starts_with("a.exr: the number of pixel (0, 0) is inf"));
}

#[test]
fn what_is_written_comes_back() {
    let values: Vec<f64> = (0..35 * 20).map(|i| f64::from((i * i) as f32 / 7.0)).collect();
    let image = Numbers { width: 35, height: 20, values };
    let written = || {
        let mut bytes = Cursor::new(Vec::new());
        image::write(&image, &mut bytes).unwrap();
        bytes.into_inner()
    };
    assert_eq!(read("a.exr", &written(), None).unwrap(), image);
    assert_eq!(written(), written());
    let refused = |image: Numbers| image::write(&image, Cursor::new(Vec::new())).is_err();
    assert!(refused(Numbers { width: 3, ..image.clone() }));
    assert!(refused(Numbers { values: vec![1e39; 700], ..image }));
}

#[test]
fn pictures_have_limits() {
    let large = png([2000, 1000], ColorType::Grayscale, BitDepth::One, &[0; 250 * 1000]);
    assert!(
        fault("a.png", &large, None)
            .contains("2000 x 1000 pixels, and 1048576 are possible; make it smaller")
    );
    let said = |size: [u32; 2]| {
        let mut bytes = png([1, 1], ColorType::Grayscale, BitDepth::Eight, &[0]);
        bytes[16..20].copy_from_slice(&size[0].to_be_bytes());
        bytes[20..24].copy_from_slice(&size[1].to_be_bytes());
        // The checksum of the header.
        let table = |mut c: u32| {
            (0..8).for_each(|_| c = if c & 1 == 1 { 0xedb8_8320 ^ c >> 1 } else { c >> 1 });
            c
        };
        let sum = bytes[12..29].iter().fold(u32::MAX, |c, b| table(c as u8 as u32 ^ u32::from(*b)) ^ c >> 8);
        bytes[29..33].copy_from_slice(&(!sum).to_be_bytes());
        let (result, memory) = peak(|| read("a.png", &bytes, None));
        assert!(memory < 1 << 20, "{memory}");
        result.unwrap_err().to_string()
    };
    assert!(said([u32::MAX >> 1; 2]).contains("2147483647 x 2147483647 pixels"));
    assert!(said([1000, 1000]).contains("1000 x 1000 pixels cannot be in"));
    assert!(said([0, 5]).contains("cannot be read"));
    assert!(fault("a.tif", b"", None).ends_with("heights are read from files that end with .png or .exr"));
}

#[test]
fn damaged_pictures_are_refused() {
    let pictures = [
        ("a.png", png([5, 4], ColorType::Rgb, BitDepth::Sixteen, &(0..120).collect::<Vec<u8>>())),
        ("a.exr", exr(&[("a", &[("R", 1.0), ("G", 2.0)]), ("b", &[("Y", 3.0)])])),
    ];
    for (name, whole) in pictures {
        // The last bytes of a PNG say that it ends.
        let enough = (0..whole.len()).filter(|end| read(name, &whole[..*end], None).is_ok()).count();
        assert!(enough <= 16, "{name}: {enough}");
        let mut random = StdRng::seed_from_u64(3);
        for _ in 0..6000 {
            let mut bytes = whole.clone();
            for _ in 0..random.random_range(1..4) {
                let at = random.random_range(0..bytes.len());
                bytes[at] = if random.random() {
                    random.random()
                } else {
                    bytes[at] ^ 1 << random.random_range(0..8)
                };
            }
            let (result, memory) = peak(|| read(name, &bytes, None));
            // What a picture of so many pixels takes, with all its channels.
            assert!(memory < 64 * MOST, "{name}: {memory}");
            if let Err(fault) = result {
                assert!(fault.to_string().starts_with(&format!("{name}: ")), "{fault}");
            }
        }
    }
}

fn samples() -> Samples {
    let frame =
        Frame { size: [4, 3, 2], origin: [1.0, 2.0, 3.0], spacing: [0.1, 0.2, 0.3], edge: Edge::Repeat };
    Samples { frame, values: (0..24).map(|i| 0.5 * f64::from(i)).collect() }
}

#[test]
fn volumes_come_back() {
    let samples = samples();
    let mut data = Vec::new();
    grid::write(&samples, &mut data).unwrap();
    assert_eq!(data.len(), 96);
    assert_eq!(grid::data_name("a/b.json"), "a/b.raw");
    let header = grid::header(&samples);
    assert_eq!(grid::read("a.json", header.as_bytes(), &data).unwrap(), samples);
    let mut others = data.clone();
    others[5] ^= 1;
    let fault = grid::read("a.json", header.as_bytes(), &others).unwrap_err().to_string();
    assert!(fault.starts_with("a.raw: these are not the numbers that a.json was written with"), "{fault}");
    let short = grid::read("a.json", b"{\"type\":\"float32\",\"size\":[4,3,2],\"more\":[]}", &data).unwrap();
    assert_eq!(
        short.frame,
        Frame { size: [4, 3, 2], origin: [0.0; 3], spacing: [1.0; 3], edge: Edge::Clamp }
    );
    let slice = grid::slice(&samples, 1).unwrap();
    assert_eq!((slice.width, slice.height), (4, 2));
    assert_eq!(slice.values, [2.0, 2.5, 3.0, 3.5, 8.0, 8.5, 9.0, 9.5]);
    assert_eq!(grid::slice(&samples, 3), None);
    let large = Samples { values: vec![1e39; 24], ..samples };
    assert!(grid::write(&large, &mut Vec::new()).is_err());
}

#[test]
fn headers_are_claims() {
    let data = vec![0; 96];
    let said = |header: &str| grid::read("a.json", header.as_bytes(), &data).unwrap_err().to_string();
    let with = |key: &str, value: &str| {
        said(
            &format!("{{\"type\":\"float32\",\"size\":[4,3,2],\"{key}\":{value}}}")
                .replace("\"size\":[4,3,2],\"size\"", "\"size\""),
        )
    };
    assert!(
        with("size", "[4,3,3]")
            .starts_with("a.raw: 4 x 3 x 3 numbers take 144 bytes, and the file has 96; correct `size`")
    );
    assert!(
        with("size", "[4000000000,4000000000,4000000000]")
            .starts_with("a.json, size: a grid of 4000000000 x")
    );
    assert!(with("size", "[0,1,1]").starts_with("a.json, size: a grid of 0 x"));
    assert!(with("size", "[1,1]").starts_with("a.json, its JSON text: invalid length"));
    assert!(with("spacing", "[1,0,1]").starts_with("a.json, spacing: samples cannot be 0 apart"));
    assert!(with("origin", "[1e30,0,1]").starts_with("a.json, origin: a grid cannot lie at"));
    assert!(with("edge", "\"mirror\"").contains("an edge is \"clamp\" or \"repeat\""));
    assert!(
        with("endian", "\"big\"")
            .starts_with("a.json, endian: \"big\" is not read; convert it to \"little\"")
    );
    assert!(said("{\"type\":\"uint8\",\"size\":[4,3,8]}").starts_with("a.json, type: \"uint8\" is not read"));
    assert!(said("[").contains("a header is such as"));
    let mut data = data.clone();
    data[40..44].copy_from_slice(&f32::NAN.to_le_bytes());
    let header = "{\"type\":\"float32\",\"size\":[4,3,2]}";
    let fault = grid::read("a.json", header.as_bytes(), &data).unwrap_err().to_string();
    assert!(fault.starts_with("a.raw, byte 40: number 10 is NaN"), "{fault}");
}
