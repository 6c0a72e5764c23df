//! A law that was compiled elsewhere is tried on a few rows of nobody's before it gets those of a client.
//!
//! In: a law that was just made. Out: nothing, or what it wrote that it should not have, or did not write that it should. A law that
//! fails on these numbers, which mean nothing, may still be right. Never: the client's memory.

use super::abi;
use super::instance::Instance;
use crate::law::{Mode, Place, Shape};

/// Rows that there are, and numbers of nobody's before and behind them.
const ROWS: usize = 8;
const GUARD: usize = 64;
/// The rows that the law is to compute.
const BEGIN: usize = 2;
const END: usize = 6;

/// What a slot's numbers are before: of no bits that a law computes.
fn before(slot: usize, place: usize) -> u64 {
    // A NaN that says where it is.
    0x7ff8_0000_0000_0000 | (slot as u64) << 16 | place as u64
}

/// # Safety
/// The module's functions do what `vesper_law.h` says, but for the rows that they write.
pub(super) unsafe fn trial(instance: &Instance) -> Result<(), String> {
    if instance.declared.table.precisions & abi::F64 == 0 {
        // What it is told is what counts, and that is the same in both.
        return Ok(());
    }
    let signature = &instance.declared.signature;
    let law = signature.name;
    let shape = instance.declared.shape;
    let (count, arity) = (instance.slots.len(), signature.link.map_or(0, |link| link.kind.width()));
    let mut memory = vec![vec![0_u64; GUARD + ROWS + GUARD]; count];
    for (slot, numbers) in memory.iter_mut().enumerate() {
        let port = instance.slots[slot].port;
        for (place, number) in numbers.iter_mut().enumerate() {
            let row = place.wrapping_sub(GUARD);
            *number = before(slot, place);
            if row < ROWS && (port.mode.is_input() || matches!(port.mode, Mode::Adds | Mode::Amends)) {
                *number = (1.0 + slot as f64 * 0.01 + row as f64 * 0.1).to_bits();
            }
        }
    }
    let known = memory.clone();
    let slots: Vec<*mut core::ffi::c_void> =
        memory.iter_mut().map(|numbers| numbers[GUARD..].as_mut_ptr().cast()).collect();
    let rows = vec![ROWS; count];
    // Links lead to rows 2 to 5 alone.
    let links: Vec<u32> = (0..(END - BEGIN) * arity).map(|end| (BEGIN + end % (END - BEGIN)) as u32).collect();
    let (begin, end) = match shape {
        Shape::Row | Shape::Pair => (BEGIN, END),
        Shape::Link => (0, END - BEGIN),
        Shape::Column => (0, ROWS),
    };
    let others = if shape == Shape::Link { END - BEGIN } else { ROWS };
    let call = abi::Call {
        struct_size: size_of::<abi::Call>() as u32,
        precision: abi::F64,
        begin,
        end,
        others_begin: 0,
        others_end: others,
        slots: slots.as_ptr(),
        strides: instance.strides.as_ptr(),
        rows: if shape == Shape::Column { rows.as_ptr() } else { core::ptr::null() },
        links: if links.is_empty() { core::ptr::null() } else { links.as_ptr() },
        native: core::ptr::null(),
    };
    // SAFETY: passed on to the caller; the slots have so many rows.
    let went = unsafe { instance.apply(&call) } == 0;
    for (slot, (found, known)) in memory.iter().zip(&known).enumerate() {
        let port = instance.slots[slot].port;
        let name = port.property.name;
        let changed = |range: core::ops::Range<usize>| range.clone().find(|&place| found[place] != known[place]);
        if let Some(place) = changed(0..GUARD).or_else(|| changed(GUARD + ROWS..2 * GUARD + ROWS)) {
            let by = place as isize - GUARD as isize;
            return Err(format!("{law} writes outside of {name}: to row {by}, where {ROWS} rows are from 0 on"));
        }
        if port.mode.is_input() {
            if let Some(place) = changed(GUARD..GUARD + ROWS) {
                let row = place - GUARD;
                return Err(format!(
                    "{law} writes to row {row} of {name}, which it says it reads: declare it as written, or leave it"
                ));
            }
            continue;
        }
        let own = match shape {
            Shape::Column => 0..ROWS,
            Shape::Link if port.place != Place::End => 0..END - BEGIN,
            Shape::Row | Shape::Pair | Shape::Link => BEGIN..END,
        };
        let outside = changed(GUARD..GUARD + own.start).or_else(|| changed(GUARD + own.end..GUARD + ROWS));
        if let Some(place) = outside {
            let (row, from, to) = (place - GUARD, own.start, own.end);
            return Err(format!(
                "{law} writes to row {row} of {name}, and was called for the rows from `begin` {from} to before `end` {to}"
            ));
        }
        let whole = matches!(port.mode, Mode::Sets | Mode::Rates) && went;
        let left = own.clone().find(|&row| found[GUARD + row] == known[GUARD + row]);
        if let (true, Some(row)) = (whole, left) {
            return Err(format!(
                "{law} {} {name}, and leaves out row {row} of those from `begin` {} to before `end` {}",
                port.mode.does(),
                own.start,
                own.end
            ));
        }
    }
    Ok(())
}
