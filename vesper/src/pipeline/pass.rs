//! Runs one pass over memory. In: a pass that is tied to a state, and what all passes of a run share. Out: results in
//! their columns, or energies. Never: an order of passes.

use super::bind::{ColumnPass, LinkPass, Located, Pass};
use super::run::Context;
use super::switches::Phase;
use super::threads::in_parts;
use crate::backend::{Kernel, LinkCall, Links, Strided};
use crate::law::{ColumnAccess, PortView};
use crate::real::Scalar;

pub(super) fn run_pass<P: Scalar>(pass: &mut Pass<P>, context: &Context<'_, P>) -> f64 {
    match pass {
        Pass::Device(pass) => {
            if !pass.run(context) {
                return run_pass(pass.host_mut(), context);
            }
        }
        // SAFETY: `Runner` is only made for a state with the layout that the program was tied to, held exclusively.
        Pass::Group(group) => return unsafe { group.run(context) },
        Pass::Pair(pass) if pass.is_one_call && context.is_unwatched() => {
            // SAFETY: the slots have a number for every row, and room behind the last one: they are columns or vectors of ours.
            unsafe { pass.kernel.run(context.isa.for_few::<P>(pass.rows), &pass.all()) };
        }
        Pass::Pair(pass) => return super::pairs::run(pass, context),
        Pass::Link(pass) => return run_link(pass, context),
        Pass::Column(pass) => run_columns(pass, context),
        Pass::Axpy { parts, stage } => add_scaled(parts, Some(context.steps[*stage]), context),
        Pass::Hold(parts) => add_scaled(parts, None, context),
        Pass::Keep { switch: true, .. } if context.phase != Phase::Free => {}
        Pass::Keep { parts, .. } => {
            for (to, from, count) in parts.iter().copied() {
                // SAFETY: both have `count` numbers, and are different columns.
                unsafe { to.copy_from_nonoverlapping(from, count) };
            }
        }
        Pass::Release(numbers) => {
            for (start, count) in numbers {
                // SAFETY: held shares are this program's own.
                unsafe { core::slice::from_raw_parts_mut(*start, *count) }.fill(P::default());
            }
        }
    }
    0.0
}

fn add_scaled<P: Scalar>(parts: &[(Located<P>, *mut P)], step: Option<P>, context: &Context<'_, P>) {
    for (to, from) in parts {
        let start = to.base.resolve(context.lent);
        for row in 0..to.len {
            // SAFETY: both have `len` numbers; the runner holds the state.
            unsafe {
                let share = *from.add(row);
                *start.add(row * to.stride) += step.map_or(share, |step| share * step);
            }
        }
    }
}

// Not in one function with the others, whose calls would then take as long as some laws.
#[inline(never)]
fn run_link<P: Scalar>(pass: &mut LinkPass<P>, context: &Context<'_, P>) -> f64 {
    let Kernel::Link(kernel) = &context.laws[pass.law].compiled.kernel else { return 0.0 };
    pass.resolved.clear();
    pass.resolved
        .extend(pass.slots.iter().map(|(base, stride)| Strided { start: base.resolve(context.lent), stride: *stride }));
    // SAFETY: the links of the layout that the program was tied to.
    let ends = unsafe { core::slice::from_raw_parts(pass.ends.0, pass.ends.1) };
    let (slots, all) = (&pass.resolved[..], Links::First(pass.links));
    let whole = LinkCall { slots, ends, links: all, rows: 0..u32::MAX };
    if pass.energy {
        // SAFETY: the slots reach all rows, and the ends were checked when the state was made.
        return unsafe { kernel.energy(&whole) }.unwrap_or_default();
    }
    context.timed(pass.law, || {
        if pass.portions.is_empty() {
            // SAFETY: as above.
            return unsafe { kernel.run(context.isa, &whole) };
        }
        let run = |portions: core::ops::Range<usize>| {
            for portion in &pass.portions[portions] {
                let call = LinkCall { slots, ends, links: Links::Listed(&portion.links), rows: portion.rows.clone() };
                // SAFETY: as above; portions have different rows.
                unsafe { kernel.run(context.isa, &call) };
            }
        };
        // SAFETY: as above.
        unsafe { in_parts(context, pass.portions.len(), pass.portions.len(), 1, run) };
    });
    context.watch(pass.law, || {
        let first = first_result(context, pass.law);
        let rows = ends.iter().max().map_or(0, |row| *row as usize + 1);
        pass.resolved[first..].iter().map(move |slot| (slot.start, slot.stride, rows))
    });
    0.0
}

/// The first slot that a law writes: results follow what it reads.
pub(super) fn first_result<P: Scalar>(context: &Context<'_, P>, law: usize) -> usize {
    let ports = context.laws[law].compiled.signature.ports;
    ports.iter().filter(|port| port.mode.is_input()).map(|port| port.property.kind.width()).sum()
}

#[inline(never)]
fn run_columns<P: Scalar>(pass: &mut ColumnPass<P>, context: &Context<'_, P>) {
    let Kernel::Column(kernel) = &context.laws[pass.law].compiled.kernel else { return };
    pass.views.clear();
    pass.views.extend(pass.ports.iter().map(|(bases, stride, rows)| PortView {
        components: bases.map(|base| base.map_or(core::ptr::null_mut(), |base| base.resolve(context.lent))),
        stride: *stride,
        rows: *rows,
    }));
    let link = pass.link.map(|(start, count, arity)| {
        // SAFETY: the links of the layout that the program was tied to.
        (unsafe { core::slice::from_raw_parts(start, count) }, arity)
    });
    // SAFETY: the views reach all rows of the columns of this law's ports; the runner holds the state.
    let access = unsafe { ColumnAccess::new(&pass.views, link) };
    context.timed(pass.law, || {
        // SAFETY: as above.
        unsafe { kernel.run(&access) };
    });
    context.watch(pass.law, || {
        let ports = context.laws[pass.law].compiled.signature.ports.iter().zip(&pass.views);
        let results = ports.filter(|(port, _)| !port.mode.is_input());
        results.flat_map(|(_, view)| view.components.map(|start| (start, view.stride, view.rows)))
    });
}
