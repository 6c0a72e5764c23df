//! Where rows went, for a picture.
//!
//! In: a state, at moments. Out: the places of every row, thinned so that a long run needs no more room than a short
//! one; the links between them at the last moment. Never: more than a few points in a pixel.

use vesper::prelude::*;

/// Moments kept of a row; beyond, every second one is dropped, and from then on only every second one is kept.
const MOST_MOMENTS: usize = 4096;
/// Of more rows than this only the first and the last moment is kept: so many trails would cover each other.
pub(crate) const MOST_TRAILS: usize = 64;

/// The places of the rows of one domain.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trail {
    pub(crate) domain: String,
    pub(crate) rows: usize,
    /// Three numbers for each row, moment by moment.
    pub(crate) moments: Vec<Vec<f64>>,
    pub(crate) last: Vec<f64>,
    seen: u64,
    stride: u64,
}

/// The places of all rows that have one.
#[derive(Clone, Debug, Default)]
pub struct Trails {
    pub(crate) list: Vec<Trail>,
    /// Domain, and rows that a link joins.
    pub(crate) links: Vec<(String, Vec<u32>)>,
    pub(crate) begin: f64,
    pub(crate) end: f64,
}

/// Every so many of `frames` frames is worth adding; 0 where a state's rows are too many for trails.
pub fn worth_adding<P: Precision>(state: &State<P>, frames: u64) -> u64 {
    let placed = state.domains().iter().filter(|domain| state.column(domain.name(), Position::NAME).is_ok());
    let rows = placed.map(|domain| domain.rows()).max().unwrap_or(0);
    if rows > MOST_TRAILS { 0 } else { frames.div_ceil(MOST_MOMENTS as u64 - 2).max(1) }
}

impl Trails {
    /// Adds a moment.
    pub fn add<P: Precision>(&mut self, state: &State<P>) {
        if self.list.is_empty() {
            self.begin = state.time().to_f64();
        }
        self.end = state.time().to_f64();
        self.links.clear();
        for domain in state.domains() {
            for (target, arity, rows) in domain.columns().iter().filter_map(Column::links) {
                self.links.extend(rows.chunks_exact(arity.max(1)).map(|ends| (target.to_owned(), ends.to_vec())));
            }
            let Ok(column) = state.column(domain.name(), Position::NAME) else { continue };
            let Ok(places) = state.numbers(domain.name(), Position) else { continue };
            // Positions of some rows only have no use as a picture of the domain.
            if column.subset().is_some() || places.is_empty() {
                continue;
            }
            let known = self.list.iter().position(|trail| trail.domain == domain.name());
            let index = known.unwrap_or_else(|| {
                let (domain, rows) = (domain.name().to_owned(), domain.rows());
                self.list.push(Trail { domain, rows, stride: 1, ..Trail::default() });
                self.list.len() - 1
            });
            self.list[index].add(places);
        }
    }
}

impl Trail {
    fn add(&mut self, places: Vec<f64>) {
        self.last.clone_from(&places);
        let due = self.seen.is_multiple_of(self.stride) && (self.rows <= MOST_TRAILS || self.moments.is_empty());
        self.seen += 1;
        if !due {
            return;
        }
        self.moments.push(places);
        if self.moments.len() >= MOST_MOMENTS {
            let mut index = 0;
            self.moments.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.stride *= 2;
        }
    }

    /// Number `axis` of `row` at each moment kept, the last one too.
    pub(crate) fn along(&self, row: usize, axis: usize) -> impl Iterator<Item = f64> {
        self.moments.iter().chain([&self.last]).map(move |places| places[3 * row + axis])
    }
}
