//! The picture that several people watch while it is made.
//!
//! It consists of square blocks. Each bears the tick of a clock at which it was painted last, so that whoever has seen
//! everything up to some tick can ask for what is new, however slowly they look: nobody keeps a list for them.

use crate::render::{Layer, Look, Pixel, Rect, View};
use glam::DVec3;

/// Side of a block in pixels.
const SIDE: u32 = 32;

/// Bytes on a screen, and how far away things are.
pub struct Canvas {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// How it is seen what is on it.
    pub view: Option<View>,
    /// Red, green and blue, row by row.
    bytes: Vec<u8>,
    /// Distances along rays; infinite where there is nothing.
    depths: Vec<f32>,
    /// When blocks were painted.
    painted: Vec<u64>,
    clock: u64,
}

/// What is new of a canvas.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct News {
    /// The blocks that were painted.
    pub blocks: Vec<Rect>,
    /// When that was, to ask from the next time.
    pub tick: u64,
}

impl Canvas {
    /// A black one.
    pub fn new([width, height]: [u32; 2]) -> Canvas {
        let count = width as usize * height as usize;
        let blocks = width.div_ceil(SIDE) as usize * height.div_ceil(SIDE) as usize;
        Canvas {
            size: [width, height],
            view: None,
            bytes: vec![0; 3 * count],
            depths: vec![f32::INFINITY; count],
            painted: vec![1; blocks],
            clock: 1,
        }
    }

    /// Another size; what was there is lost if it differs.
    pub fn resize(&mut self, size: [u32; 2]) {
        if size != self.size {
            let clock = self.clock + 1;
            *self = Canvas::new(size);
            self.clock = clock;
            self.painted.fill(clock);
        }
    }

    /// The pixels of the rectangle within the canvas, row by row, from a function of column and row.
    pub fn paint(&mut self, rect: &Rect, layer: Layer, look: &Look, pixel: impl Fn(u32, u32) -> Pixel) {
        let [width, height] = self.size;
        let Some(rect) = rect.intersection(&Rect::whole(width, height)) else { return };
        for y in rect.y..rect.bottom() {
            for x in rect.x..rect.right() {
                let at = y as usize * width as usize + x as usize;
                let pixel = pixel(x, y);
                self.bytes[3 * at..3 * at + 3].copy_from_slice(&layer.bytes(&pixel, look, at as u64));
                self.depths[at] = pixel.depth;
            }
        }
        self.touch(&rect);
    }

    /// The same for a rectangle all of whose pixels are alike.
    pub fn fill(&mut self, rect: &Rect, layer: Layer, look: &Look, pixel: &Pixel) {
        let [width, height] = self.size;
        let Some(rect) = rect.intersection(&Rect::whole(width, height)) else { return };
        let bytes = layer.bytes(pixel, look, 0);
        for y in rect.y as usize..rect.bottom() as usize {
            let start = y * width as usize + rect.x as usize;
            let row = start..start + rect.width as usize;
            self.depths[row.clone()].fill(pixel.depth);
            self.bytes[3 * row.start..3 * row.end]
                .chunks_exact_mut(3)
                .for_each(|p| p.copy_from_slice(&bytes));
        }
        self.touch(&rect);
    }

    fn touch(&mut self, rect: &Rect) {
        self.clock += 1;
        let across = self.size[0].div_ceil(SIDE);
        for row in rect.y / SIDE..=(rect.bottom() - 1) / SIDE {
            for column in rect.x / SIDE..=(rect.right() - 1) / SIDE {
                self.painted[(row * across + column) as usize] = self.clock;
            }
        }
    }

    /// What was painted after a tick; 0 asks for everything.
    pub fn since(&self, tick: u64) -> News {
        let [width, height] = self.size;
        let across = width.div_ceil(SIDE);
        let block = |i: usize| {
            let (x, y) = (i as u32 % across * SIDE, i as u32 / across * SIDE);
            Rect { x, y, width: SIDE.min(width - x), height: SIDE.min(height - y) }
        };
        let new = self.painted.iter().enumerate().filter(|(_, painted)| **painted > tick);
        News { blocks: new.map(|(i, _)| block(i)).collect(), tick: self.clock }
    }

    /// Puts a block behind others: column, row, width, height and the side of its cells as 16-bit numbers, lowest byte
    /// first; then red, green and blue of each cell, row by row. All pixels of a cell, a square but for the ends of the
    /// block, are alike, so that rough pictures are short.
    pub fn pack(&self, block: &Rect, out: &mut Vec<u8>) {
        let mut side = SIDE;
        while side > 1 && !self.has_cells(block, side) {
            side /= 2;
        }
        let head = [block.x, block.y, block.width, block.height, side];
        out.extend(head.into_iter().flat_map(|n| (n as u16).to_le_bytes()));
        for y in (block.y..block.bottom()).step_by(side as usize) {
            for x in (block.x..block.right()).step_by(side as usize) {
                out.extend_from_slice(self.color(x, y));
            }
        }
    }

    fn color(&self, x: u32, y: u32) -> &[u8] {
        let at = 3 * (y as usize * self.size[0] as usize + x as usize);
        &self.bytes[at..at + 3]
    }

    /// Whether a block consists of cells of a side, each of one colour.
    fn has_cells(&self, block: &Rect, side: u32) -> bool {
        let first = |at: u32, start: u32| at - (at - start) % side;
        (block.y..block.bottom()).all(|y| {
            let top = first(y, block.y);
            (block.x..block.right()).all(|x| self.color(x, y) == self.color(first(x, block.x), top))
        })
    }

    /// The point that is seen at a place in pixels, if there is one.
    pub fn point(&self, [x, y]: [f64; 2], view: &View) -> Option<DVec3> {
        let [width, height] = self.size;
        let inside = (0.0..f64::from(width)).contains(&x) && (0.0..f64::from(height)).contains(&y);
        let depth = inside.then(|| self.depths[y as usize * width as usize + x as usize])?;
        let (origin, direction) = view.ray(x, y, [0.5, 0.5]);
        depth.is_finite().then(|| origin + f64::from(depth) * direction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Tone};

    fn look() -> Look {
        Look { background: [0.0; 3], exposure: 0.0, tone: Tone::Neutral, near: 1.0 }
    }

    fn white() -> Pixel {
        Pixel { color: [4.0; 3], alpha: 1.0, depth: 2.0, ..Pixel::EMPTY }
    }

    #[test]
    fn whoever_looks_again_sees_what_is_new() {
        let mut canvas = Canvas::new([70, 40]);
        let all = canvas.since(0);
        assert_eq!(all.blocks.iter().map(Rect::area).sum::<u64>(), 70 * 40);
        assert_eq!(canvas.since(all.tick).blocks, []);
        canvas.paint(&Rect { x: 60, y: 30, width: 100, height: 100 }, Layer::Light, &look(), |_, _| white());
        let new = canvas.since(all.tick);
        assert_eq!(new.blocks.len(), 4);
        assert_eq!(new.blocks[3], Rect { x: 64, y: 32, width: 6, height: 8 });
        canvas.resize([70, 40]);
        assert_eq!(canvas.since(new.tick).blocks, []);
        canvas.resize([8, 8]);
        assert_eq!(canvas.since(new.tick).blocks, [Rect::whole(8, 8)]);
    }

    /// What a receiver makes of a packed block.
    fn unpack(bytes: &[u8]) -> (Rect, Vec<u8>) {
        let number = |i: usize| u32::from(u16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]]));
        let (rect, side) =
            (Rect { x: number(0), y: number(1), width: number(2), height: number(3) }, number(4));
        let across = rect.width.div_ceil(side);
        let places = (0..rect.height).flat_map(|y| (0..rect.width).map(move |x| (x, y)));
        let cell = |(x, y): (u32, u32)| 10 + 3 * (y / side * across + x / side) as usize;
        let pixels = places.flat_map(|p| bytes[cell(p)..cell(p) + 3].to_vec()).collect();
        assert_eq!(bytes.len(), 10 + (3 * across * rect.height.div_ceil(side)) as usize);
        (rect, pixels)
    }

    #[test]
    fn blocks_are_packed_as_short_as_they_are_rough() {
        let mut canvas = Canvas::new([40, 40]);
        let grey = |x: u32| Pixel { color: [x as f32 / 40.0; 3], ..white() };
        let blocks = canvas.since(0).blocks;
        let packed = |canvas: &Canvas, i: usize| {
            let mut bytes = Vec::new();
            canvas.pack(&blocks[i], &mut bytes);
            let (rect, pixels) = unpack(&bytes);
            assert_eq!(rect, blocks[i]);
            let rows = rect.y..rect.bottom();
            let real = rows.flat_map(|y| (rect.x..rect.right()).flat_map(move |x| [(x, y)]));
            assert_eq!(pixels, real.flat_map(|(x, y)| canvas.color(x, y).to_vec()).collect::<Vec<_>>());
            bytes.len() - 10
        };
        assert_eq!([0, 1, 2, 3].map(|i| packed(&canvas, i)), [3; 4]);
        for x in (0..40).step_by(4) {
            canvas.fill(&Rect { x, y: 0, width: 4, height: 40 }, Layer::Light, &look(), &grey(x));
        }
        assert_eq!([0, 1, 2, 3].map(|i| packed(&canvas, i)), [3 * 64, 3 * 16, 3 * 16, 3 * 4]);
        canvas.paint(&Rect::whole(40, 40), Layer::Light, &look(), |x, y| grey(x ^ y));
        assert_eq!(packed(&canvas, 3), 3 * 64);
    }

    #[test]
    fn points_are_where_pixels_see_them() {
        let mut canvas = Canvas::new([8, 8]);
        let camera = Camera::look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO);
        let view = View::new(&camera, 8, 8).unwrap();
        assert_eq!(canvas.point([4.0, 4.0], &view), None);
        canvas.paint(&Rect::whole(8, 8), Layer::Light, &look(), |_, _| white());
        assert!(canvas.point([4.0, 4.0], &view).unwrap().distance(DVec3::new(0.0, 0.0, 3.0)) < 1e-12);
        assert_eq!(canvas.point([8.0, 4.0], &view), None);
    }
}
