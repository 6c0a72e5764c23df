//! A grid of cells for each size of sphere, so that a body looks at the spheres near it and not at all of them.
//!
//! In: spheres, each around a place within another one. Out: those that may hold a place, the smallest sizes first. Never:
//! whether they do.
//!
//! A sphere is in all cells that it reaches, eight at most, and a place looks into one of each size. Bodies that go round the
//! same one are not in each other's spheres, or they would go round each other: of one size a cell has a few at most, however
//! many there are. Sizes are powers of two, so that there are tens of them at most.

use super::NONE;

/// Spheres whose radius is a smaller part of the distance than this hold nothing: places in f64 are not much finer.
const LEAST: f64 = 1e-14;

/// Where spheres are.
pub(super) struct Cells {
    /// The last of the entries in each bucket of cells; of each entry the body, and the entry before it.
    buckets: Vec<u32>,
    entries: Vec<[u32; 2]>,
    /// The size of each body's sphere: its radius is from 2^size to 2^(size + 1).
    size: Vec<i16>,
    /// The sizes of spheres that there are within each body's sphere, smallest first.
    sizes: Vec<Vec<i16>>,
}

impl Cells {
    pub(super) fn new(bodies: usize) -> Self {
        Cells {
            buckets: vec![NONE; (4 * bodies).next_power_of_two()],
            entries: Vec::new(),
            size: vec![0; bodies],
            sizes: vec![Vec::new(); bodies],
        }
    }

    pub(super) fn insert(&mut self, body: u32, around: u32, way: [f64; 3], radius: f64) {
        let far = way.iter().fold(0.0, |far, along| f64::max(far, along.abs()));
        // What is no number is not inserted either.
        if !(radius.is_finite() && radius > LEAST * far) {
            return;
        }
        let size = radius.log2().floor() as i16;
        self.size[body as usize] = size;
        let sizes = &mut self.sizes[around as usize];
        if let Err(at) = sizes.binary_search(&size) {
            sizes.insert(at, size);
        }
        // A radius is less than a quarter of the width; half as much again makes up for rounding.
        let [low, high] = [-0.375, 0.375].map(|off| cell(way, size, off));
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let bucket = self.bucket(around, size, [x, y, z]);
                    self.entries.push([body, self.buckets[bucket]]);
                    self.buckets[bucket] = self.entries.len() as u32 - 1;
                }
            }
        }
    }

    /// Looks at spheres near a place, until one of the size looked at is found. Spheres within others may be among them.
    pub(super) fn near(&self, around: u32, way: [f64; 3], look: &mut impl FnMut(u32) -> bool) {
        for &size in &self.sizes[around as usize] {
            let mut found = false;
            let mut entry = self.buckets[self.bucket(around, size, cell(way, size, 0.0))];
            while entry != NONE {
                let [body, before] = self.entries[entry as usize];
                // Others share the bucket.
                found |= self.size[body as usize] == size && look(body);
                entry = before;
            }
            if found {
                return;
            }
        }
    }

    /// By multiplications with the golden ratio, as in Knuth, The Art of Computer Programming 3, sec. 6.4.
    fn bucket(&self, around: u32, size: i16, cell: [i64; 3]) -> usize {
        let parts =
            [(u64::from(around) << 16) ^ u64::from(size as u16), cell[0] as u64, cell[1] as u64, cell[2] as u64];
        let mixed = parts.into_iter().fold(0_u64, |mixed, part| {
            let mixed = (mixed ^ part).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            mixed ^ mixed >> 32
        });
        mixed as usize & (self.buckets.len() - 1)
    }
}

/// The cell of this size in which a place is, or one that is off by so many widths along each axis.
fn cell(way: [f64; 3], size: i16, off: f64) -> [i64; 3] {
    let width = 2.0_f64.powi(i32::from(size) + 3);
    way.map(|along| (along / width + off).floor() as i64)
}
