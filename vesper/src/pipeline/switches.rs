//! What a step ends at: switches of laws that turn, and regions of fields that rows leave.
//!
//! In: evaluations, of which one begins to hold, and others look. Out: whether something has turned since then, and where on
//! the way. Owned by the pipeline. Never: a step; integrators take those.

use super::Pipeline;
use super::plan::{Op, Plan};
use crate::column::Storage;
use crate::field::Field;
use crate::property::{Kind, Role};
use crate::real::{Scalar, Vector};
use crate::registry::QuantityId;
use crate::state::State;

/// What an evaluation does about switches and regions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Nothing is held: a field is sampled where a row is, and switches are those of the last evaluation.
    #[default]
    Free,
    /// Regions are taken from where rows are, and how deep in them each row is, is noted.
    Hold,
    /// Regions and switches are those that were held.
    Held,
    /// The same, and it is noted how deep in its region each row is.
    Look,
}

/// The rows at which a field with regions is sampled.
pub(crate) struct Regions<P> {
    field: usize,
    domain: usize,
    rows: Option<Vec<u32>>,
    /// The region that each row is held in.
    region: Vec<u64>,
    /// The region that it was in when that was last noted, and how deep it was in the one that it is held in.
    next: Vec<u64>,
    depth: Vec<P>,
}

/// Where a group finds the regions of its rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RegionsAt<P> {
    region: *mut u64,
    next: *mut u64,
    depth: *mut P,
}

/// A scalar that turns: as the last evaluation left it, and as it is held.
struct Turning<P> {
    now: *mut P,
    held: *mut P,
    len: usize,
}

/// Numbers that are positive as long as nothing has turned, for each row: at the last place where nothing had, at the first
/// one where something had, and at the one at hand.
#[derive(Clone, Default)]
struct Bracket {
    low: Vec<f64>,
    high: Vec<f64>,
    now: Vec<f64>,
}

/// Everything that steps end at.
pub(crate) struct Switches<P: Scalar> {
    /// Components of switches, whatever their kind: (held, now, rows).
    kept: Vec<(*mut P, *mut P, usize)>,
    /// Those of them that are of no scalar.
    drifting: Vec<(*mut P, *mut P, usize)>,
    turning: Vec<Turning<P>>,
    regions: Vec<Regions<P>>,
    /// Of `turning`, then of `regions`.
    brackets: Vec<Bracket>,
    /// Whether what is held, and noted, is that of the state as it is.
    pub(crate) holds: bool,
}

impl<P: Scalar> Default for Switches<P> {
    fn default() -> Self {
        Switches {
            kept: Vec::new(),
            drifting: Vec::new(),
            turning: Vec::new(),
            regions: Vec::new(),
            brackets: Vec::new(),
            holds: false,
        }
    }
}

impl<P: Scalar> Switches<P> {
    /// Of the operations that these plans have, on a state whose columns are all there.
    pub(crate) fn new(plans: &[Plan], pipeline: &Pipeline<P>, state: &State<P>) -> Self {
        let mut switches = Switches::default();
        let mut known: Vec<QuantityId> = Vec::new();
        for op in plans.iter().flat_map(|plan| &plan.passes).flatten() {
            if let Op::Sample { field } = op.op
                && state.fields[field].1.has_regions()
            {
                switches.sampled(field, op.domain, op.rows.as_ref(), state);
            }
            for operand in &op.operands {
                if let Some(id) = operand.quantity()
                    && pipeline.registry.quantities[id].info.role == Role::Switch
                    && !known.contains(&id)
                {
                    known.push(id);
                    switches.switch(id, pipeline, state);
                }
            }
        }
        let rows = switches.turning.iter().map(|turning| turning.len);
        let rows: Vec<usize> = rows.chain(switches.regions.iter().map(|regions| regions.region.len())).collect();
        let bracket = |rows: usize| Bracket { low: vec![0.0; rows], high: vec![0.0; rows], now: vec![0.0; rows] };
        switches.brackets = rows.into_iter().map(bracket).collect();
        switches
    }

    fn sampled(&mut self, field: usize, domain: usize, rows: Option<&Vec<u32>>, state: &State<P>) {
        if self.find(field, domain, rows).is_none() {
            let count = rows.map_or(state.domains[domain].rows, Vec::len);
            self.regions.push(Regions {
                field,
                domain,
                rows: rows.cloned(),
                region: vec![0; count],
                next: vec![0; count],
                depth: vec![P::default(); count],
            });
        }
    }

    fn switch(&mut self, id: QuantityId, pipeline: &Pipeline<P>, state: &State<P>) {
        let known = &pipeline.registry.quantities[id];
        let domain = &state.domains[known.domain];
        let Some(now) = domain.find(known.info.name).map(|at| &domain.columns[at]) else { return };
        let Some(held) = domain.previous.iter().find(|column| column.info.name == known.info.name) else { return };
        let (Storage::Split(now), Storage::Split(held)) = (&now.storage, &held.storage) else { return };
        let pointers = held.iter().zip(now).map(|(held, now)| (held.pointer(), now.pointer(), domain.rows));
        if known.info.kind != Kind::Scalar {
            self.drifting.extend(pointers.clone());
        }
        self.kept.extend(pointers);
        if let (Kind::Scalar, [held], [now]) = (known.info.kind, &held[..], &now[..]) {
            self.turning.push(Turning { now: now.pointer(), held: held.pointer(), len: domain.rows });
        }
    }

    fn find(&self, field: usize, domain: usize, rows: Option<&Vec<u32>>) -> Option<usize> {
        let same = |known: &Regions<P>| known.field == field && known.domain == domain && known.rows.as_ref() == rows;
        self.regions.iter().position(same)
    }

    /// Where the regions of these rows are.
    pub(crate) fn at(&self, field: usize, domain: usize, rows: Option<&Vec<u32>>) -> Option<RegionsAt<P>> {
        let regions = &self.regions[self.find(field, domain, rows)?];
        // Nobody reads or writes them but through these pointers while programs run.
        Some(RegionsAt {
            region: regions.region.as_ptr().cast_mut(),
            next: regions.next.as_ptr().cast_mut(),
            depth: regions.depth.as_ptr().cast_mut(),
        })
    }

    /// Whether there is anything that a step ends at.
    #[inline]
    pub(crate) fn any(&self) -> bool {
        !(self.kept.is_empty() && self.regions.is_empty())
    }

    /// Holds what the last evaluation left. Whether a switch is then on another side than before.
    ///
    /// # Safety
    /// The state that the switches were made for is held.
    pub(crate) unsafe fn keep(&mut self) -> bool {
        // SAFETY: both have that many numbers.
        let turned = self.turning.iter().any(|turning| unsafe {
            let (now, held) = (turning.now, turning.held);
            (0..turning.len).any(|row| is_below(*now.add(row)) != is_below(*held.add(row)))
        });
        for &(held, now, rows) in &self.kept {
            // SAFETY: as above, and they are different columns.
            unsafe { held.copy_from_nonoverlapping(now, rows) };
        }
        turned
    }

    /// Notes where everything is, after an evaluation that looked; whether something has turned.
    ///
    /// # Safety
    /// As for [`Switches::keep`].
    unsafe fn look(&mut self) -> bool {
        let Switches { turning, regions, brackets, .. } = self;
        let (of_turning, of_regions) = brackets.split_at_mut(turning.len());
        for (turning, bracket) in turning.iter().zip(of_turning) {
            for (row, to) in bracket.now.iter_mut().enumerate() {
                // SAFETY: both have that many numbers.
                let (now, held) = unsafe { (*turning.now.add(row), *turning.held.add(row)) };
                let distance = if is_below(held) { -now.to_f64() } else { now.to_f64() };
                // On the border itself it may have turned all the same.
                let turned = is_below(now) != is_below(held);
                *to = if turned { distance.min(-f64::MIN_POSITIVE) } else { distance.max(f64::MIN_POSITIVE) };
            }
        }
        for (regions, bracket) in regions.iter().zip(of_regions) {
            for (to, depth) in bracket.now.iter_mut().zip(&regions.depth) {
                *to = depth.to_f64();
            }
        }
        brackets.iter().any(|bracket| bracket.now.iter().any(|distance| *distance < 0.0))
    }

    /// Holds what the last evaluation, which looked, left, in the regions that it found: after a step that ends where
    /// something turned. What has turned stays so, though the state is rounded once more.
    ///
    /// # Safety
    /// As for [`Switches::keep`].
    pub(crate) unsafe fn turn(&mut self) {
        // SAFETY: passed on to the caller.
        unsafe { self.keep() };
        self.regions.iter_mut().for_each(|regions| regions.region.copy_from_slice(&regions.next));
    }

    /// Notes where everything is, after an evaluation that began to hold.
    ///
    /// # Safety
    /// As for [`Switches::keep`].
    pub(crate) unsafe fn note(&mut self) {
        // SAFETY: passed on to the caller.
        unsafe { self.look() };
        self.holds = true;
    }

    /// A step begins where everything was last noted. Switches that are no scalars do not turn, and are held anew.
    ///
    /// # Safety
    /// As for [`Switches::keep`].
    pub(crate) unsafe fn begin(&mut self) {
        for &(held, now, rows) in &self.drifting {
            // SAFETY: both have that many numbers, and are different columns.
            unsafe { held.copy_from_nonoverlapping(now, rows) };
        }
        self.brackets.iter_mut().for_each(|bracket| bracket.low.copy_from_slice(&bracket.now));
    }

    /// Whether something has turned, after an evaluation that looked; the bracket is then this place and the last one where
    /// nothing had.
    ///
    /// # Safety
    /// As for [`Switches::keep`].
    pub(crate) unsafe fn turned(&mut self) -> bool {
        // SAFETY: passed on to the caller.
        let turned = unsafe { self.look() };
        for Bracket { low, high, now } in &mut self.brackets {
            if turned { high } else { low }.copy_from_slice(now);
        }
        self.holds = !turned;
        turned
    }

    /// Where in the bracket the first row turns, by straight lines between the ends, each weighed.
    pub(crate) fn share(&self, [low_weight, high_weight]: [f64; 2]) -> f64 {
        let rows = self.brackets.iter().flat_map(|bracket| bracket.low.iter().zip(&bracket.high));
        let crossing = rows.filter(|(_, high)| **high < 0.0).map(|(low, high)| {
            let (low, high) = (low_weight * low.max(0.0), high_weight * high);
            low / (low - high)
        });
        crossing.fold(1.0, f64::min)
    }
}

/// Which side of its border a switch is on.
fn is_below<P: Scalar>(value: P) -> bool {
    value < P::default()
}

impl<P: Scalar> RegionsAt<P> {
    /// The region that a row is held in.
    ///
    /// # Safety
    /// The row is of those that the regions were made for.
    pub(crate) unsafe fn held(self, row: usize) -> u64 {
        // SAFETY: passed on to the caller.
        unsafe { *self.region.add(row) }
    }

    /// Samples a field at some rows, from `first` on.
    ///
    /// # Safety
    /// The rows are of those that the regions were made for, and nobody else touches theirs.
    pub(crate) unsafe fn sample(
        self,
        (field, phase, time): (&dyn Field<P>, Phase, P),
        first: usize,
        [x, y, z]: [&[P]; 3],
        [to_x, to_y, to_z]: [&mut [P]; 3],
    ) {
        for row in 0..x.len() {
            let place = P::Vec3::new(x[row], y[row], z[row]);
            // SAFETY: the caller promises the rows.
            let (region, depth) = unsafe { (&mut *self.region.add(first + row), &mut *self.depth.add(first + row)) };
            if phase == Phase::Hold {
                *region = field.region(place);
            }
            if phase != Phase::Held {
                let inside = field.depth(*region, place);
                let least = P::from_f64(f64::MIN_POSITIVE.max(P::EPSILON * P::EPSILON));
                let now = field.region(place);
                // SAFETY: as above.
                unsafe { *self.next.add(first + row) = now };
                *depth = match now == *region {
                    true => inside.max(least),
                    false => inside.min(-least),
                };
            }
            let value = field.sample_in(*region, place, time);
            (to_x[row], to_y[row], to_z[row]) = (value.x(), value.y(), value.z());
        }
    }
}
