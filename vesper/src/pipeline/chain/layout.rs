//! Which register each component of a chain's quantities has, and in which order its laws run: all in constants.

use crate::backend::MAX_SLOTS;
use crate::law::{Mode, Place, Port, Shape, Signature};
use crate::property::Role;

/// Registers of a chain: components of different quantities.
pub(crate) const REGISTERS: usize = 48;
/// Laws of a chain.
pub(crate) const LAWS: usize = 16;

/// The declarations of a chain's laws.
#[derive(Clone, Copy, Debug)]
pub struct List {
    pub(super) items: [Option<(Signature, Shape)>; LAWS],
    pub(super) len: usize,
}

impl List {
    pub(crate) const EMPTY: List = List { items: [None; LAWS], len: 0 };

    /// The list with one more law in front.
    #[must_use]
    pub const fn with_first(self, signature: Signature, shape: Shape) -> List {
        assert!(self.len < LAWS, "pipeline! takes at most 16 laws: list the others one by one");
        let mut items = [None; LAWS];
        items[0] = Some((signature, shape));
        let mut k = 0;
        while k < self.len {
            items[k + 1] = self.items[k];
            k += 1;
        }
        List { items, len: self.len + 1 }
    }

    pub(super) const fn signature(&self, law: usize) -> Signature {
        match self.items[law] {
            Some((signature, _)) => signature,
            None => panic!("no such law"),
        }
    }

    pub(crate) const fn all_rows(&self) -> bool {
        let mut law = 0;
        while law < self.len {
            match self.items[law] {
                Some((_, shape)) if super::is_row(shape) => {}
                _ => return false,
            }
            law += 1;
        }
        true
    }
}

/// What a register holds when a loop begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Content {
    Given,
    Constant,
    Optional,
    OptionalConstant,
    Field,
    Sum,
    Set,
}

/// Registers and order of a chain.
#[derive(Clone, Debug)]
pub struct Layout {
    /// By law and slot.
    pub(crate) registers: [[u8; MAX_SLOTS]; LAWS],
    pub(crate) kinds: [Content; REGISTERS],
    pub(crate) kicked: [bool; REGISTERS],
    pub(crate) drifted: [bool; REGISTERS],
    pub(crate) count: usize,
    /// The laws in the order of an evaluation.
    pub(crate) order: [usize; LAWS],
    names: [(&'static str, Place); REGISTERS],
    /// Whether all laws that read a constant say the same of it, so that one register serves them.
    pub(crate) agrees: bool,
}

impl Layout {
    /// The layout of a list whose laws are all row laws; of other lists nobody asks.
    pub(crate) const fn new(list: &List) -> Layout {
        let mut layout = Layout {
            registers: [[0; MAX_SLOTS]; LAWS],
            kinds: [Content::Given; REGISTERS],
            kicked: [false; REGISTERS],
            drifted: [false; REGISTERS],
            count: 0,
            order: order(list),
            names: [("", Place::Own); REGISTERS],
            agrees: true,
        };
        let mut ports_of = [None; REGISTERS];
        if !list.all_rows() {
            return layout;
        }
        let mut law = 0;
        while law < list.len {
            let ports = list.signature(law).ports;
            let (mut port, mut slot) = (0, 0);
            while port < ports.len() {
                let declared = ports[port];
                let first = layout.find_or_add(declared.property.name, declared.place, declared.property.kind.width());
                match ports_of[first] {
                    None => ports_of[first] = Some(declared),
                    Some(other) => layout.agrees = layout.agrees && same_constant(&other, &declared),
                }
                let mut component = 0;
                while component < declared.property.kind.width() {
                    let register = first + component;
                    layout.registers[law][slot] = register as u8;
                    layout.note(register, &declared);
                    slot += 1;
                    component += 1;
                }
                port += 1;
            }
            law += 1;
        }
        layout
    }

    const fn find_or_add(&mut self, name: &'static str, place: Place, width: usize) -> usize {
        let mut register = 0;
        while register < self.count {
            if same(self.names[register].0, name) && self.names[register].1 as u8 == place as u8 {
                return register;
            }
            register += 1;
        }
        assert!(self.count + width <= REGISTERS, "the laws of pipeline! touch too many numbers: list some one by one");
        let first = self.count;
        while self.count < first + width {
            // Only the first component carries the name, so that a search finds the first.
            self.names[self.count] = (if self.count == first { name } else { "" }, place);
            self.count += 1;
        }
        first
    }

    const fn note(&mut self, register: usize, port: &Port) {
        let constant = matches!(port.place, Place::Scene);
        match port.mode {
            Mode::Rates => {
                self.kicked[register] = !matches!(port.property.role, Role::Coordinate);
                self.drifted[register] = matches!(port.property.role, Role::Coordinate);
            }
            Mode::Sets | Mode::Amends => self.kinds[register] = Content::Set,
            Mode::Adds => self.kinds[register] = Content::Sum,
            Mode::Reads | Mode::Previous => {
                if port.property.role.is_sum() {
                    self.kinds[register] = Content::Sum;
                } else if matches!(self.kinds[register], Content::Set) {
                } else if matches!(port.place, Place::Field) {
                    self.kinds[register] = Content::Field;
                } else if port.optional && constant {
                    self.kinds[register] = Content::OptionalConstant;
                } else if constant {
                    self.kinds[register] = Content::Constant;
                } else if port.optional {
                    self.kinds[register] = Content::Optional;
                }
            }
        }
    }

    /// The registers that the chain itself fills; or, of a plain one, those that have a column or a number. One bit each.
    pub(super) const fn present(&self, given: bool) -> u64 {
        let (mut register, mut mask) = (0, 0_u64);
        while register < self.count {
            let of_kind = match self.kinds[register] {
                Content::Sum | Content::Set => !given,
                Content::Given | Content::Constant | Content::Field => given,
                Content::Optional | Content::OptionalConstant => false,
            };
            if of_kind {
                mask |= 1 << register;
            }
            register += 1;
        }
        mask
    }

    /// Whether nothing optional is there, sums begin at zero, and all fields are uniform: what most runs are, and what a
    /// loop of its own is made for.
    pub(super) fn is_plain(&self, present: u64, uniform: u64) -> bool {
        let has = |mask: u64, register: usize| mask >> register & 1 == 1;
        (0..self.count).all(|register| match self.kinds[register] {
            Content::Given | Content::Constant | Content::Set => true,
            Content::Optional | Content::OptionalConstant | Content::Sum => !has(present, register),
            Content::Field => has(present, register) && has(uniform, register),
        })
    }

    pub(crate) fn first_of(&self, name: &str) -> Option<usize> {
        self.names[..self.count].iter().position(|known| *known == (name, Place::Own))
    }
}

/// Whether two declarations of a constant have the same default.
const fn same_constant(one: &Port, other: &Port) -> bool {
    if !matches!(one.place, Place::Scene) {
        return true;
    }
    match (one.default, other.default) {
        (None, None) => one.optional == other.optional,
        (Some(one), Some(other)) => one[0] == other[0] && one[1] == other[1] && one[2] == other[2],
        _ => false,
    }
}

/// Whether two names are the same, in constants.
pub(super) const fn same(one: &str, other: &str) -> bool {
    !less(one, other) && !less(other, one)
}

/// Whether one name stands before another, in constants.
pub(super) const fn less(one: &str, other: &str) -> bool {
    let (one, other) = (one.as_bytes(), other.as_bytes());
    let mut k = 0;
    while k < one.len() && k < other.len() {
        if one[k] != other[k] {
            return one[k] < other[k];
        }
        k += 1;
    }
    one.len() < other.len()
}

/// Whether two ports surely are of the same property on the same rows: only a state knows which domain a law finds that
/// declares none, and which one a link leads to.
pub(super) const fn one_quantity(first: &Signature, mine: &Port, second: &Signature, its: &Port) -> bool {
    let one_domain = match (first.domain, second.domain) {
        (Some(one), Some(other)) => same(one, other),
        _ => true,
    };
    let one_place = match (mine.place, its.place) {
        (Place::Own, Place::Own) => one_domain,
        (Place::Scene, Place::Scene) | (Place::Field, Place::Field) => true,
        _ => false,
    };
    one_place && same(mine.property.name, its.property.name)
}

/// Whether the first law must run before the second one.
pub(super) const fn before(first: &Signature, second: &Signature) -> bool {
    let mut a = 0;
    while a < first.ports.len() {
        let mut b = 0;
        while b < second.ports.len() {
            let (one, other) = (first.ports[a], second.ports[b]);
            let ordered = matches!(
                (one.mode, other.mode),
                (Mode::Sets, Mode::Adds | Mode::Reads)
                    | (Mode::Adds, Mode::Reads)
                    | (Mode::Previous, Mode::Sets | Mode::Adds)
            );
            if ordered && one_quantity(first, &one, second, &other) {
                return true;
            }
            b += 1;
        }
        a += 1;
    }
    false
}

/// The laws in the order of an evaluation: free ones by name. A circle leaves the rest in the order of the list; the
/// check reports it.
const fn order(list: &List) -> [usize; LAWS] {
    let mut order = [0; LAWS];
    let mut done = [false; LAWS];
    let mut count = 0;
    while count < list.len {
        let mut next = LAWS;
        let mut any = LAWS;
        let mut law = 0;
        while law < list.len {
            if !done[law] {
                if any == LAWS {
                    any = law;
                }
                let mut free = true;
                let mut other = 0;
                while other < list.len {
                    if !done[other] && other != law && before(&list.signature(other), &list.signature(law)) {
                        free = false;
                    }
                    other += 1;
                }
                if free && (next == LAWS || less(list.signature(law).name, list.signature(next).name)) {
                    next = law;
                }
            }
            law += 1;
        }
        if next == LAWS {
            next = any;
        }
        done[next] = true;
        order[count] = next;
        count += 1;
    }
    order
}
