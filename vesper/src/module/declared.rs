//! A law's declaration, as a module has it, checked and turned into a [`Signature`].
//!
//! In: a table in somebody else's memory. Out: a signature, kept for the life of the program as modules are; or everything that is
//! wrong with the table, a sentence each. Never: a call of the module's code.

use super::abi;
use crate::dimension::{Dimension, Unit};
use crate::law::{MAX_SLOTS, Mode, Parameter, Place, Port, Shape, Signature};
use crate::property::{Kind, PropertyInfo, Role, STANDARD_PROPERTIES, intern};
use core::ffi::{CStr, c_char};
use core::mem::offset_of;

/// A law of a module, read once.
#[derive(Debug)]
pub(super) struct Declared {
    pub(super) table: &'static abi::Law,
    pub(super) signature: Signature,
    pub(super) shape: Shape,
    /// What its laws may ask for.
    pub(super) host: abi::Host,
}

// SAFETY: a table is not written to, nor is what it points to; the host's context is a name.
unsafe impl Send for Declared {}
// SAFETY: as above.
unsafe impl Sync for Declared {}

/// Bytes of the structures of version 1, whatever has been added to them since: less is cut off.
const LAW_SIZE: usize = offset_of!(abi::Law, load) + size_of::<usize>();
const PORT_SIZE: usize = offset_of!(abi::Port, from) + size_of::<u64>();
const PARAMETER_SIZE: usize = offset_of!(abi::Parameter, default_value) + size_of::<[f64; 3]>();

/// A structure of so many bytes: what it has less than this host's is zero, what it has more is left.
///
/// # Safety
/// There are so many bytes; zeros are a value of the structure.
pub(super) unsafe fn copied<T>(from: *const T, size: usize) -> T {
    let mut to = core::mem::MaybeUninit::<T>::zeroed();
    // SAFETY: passed on to the caller.
    unsafe {
        from.cast::<u8>().copy_to_nonoverlapping(to.as_mut_ptr().cast(), size.min(size_of::<T>()));
        to.assume_init()
    }
}

/// Reads the table of one law.
///
/// # Safety
/// The pointer is null, or points to a table as [`abi`] has it that stays, with as many bytes as its first number says.
pub(super) unsafe fn declared(law: *const abi::Law) -> Result<Declared, Vec<String>> {
    if law.is_null() {
        return Err(vec!["its table has an empty place: there is a pointer for each of `law_count` laws".to_owned()]);
    }
    // SAFETY: it has at least its size.
    let size = unsafe { (&raw const (*law).struct_size).read() } as usize;
    if size < LAW_SIZE {
        let text = format!(
            "the table of a law has {size} bytes, and {LAW_SIZE} are needed: set `struct_size` to `sizeof(vesper_law)`"
        );
        return Err(vec![text]);
    }
    // SAFETY: the table has these bytes, and zeros are no pointers and no functions.
    let table: &'static abi::Law = Box::leak(Box::new(unsafe { copied(law, size) }));
    let mut reader = Reader { wrong: Vec::new() };
    // SAFETY: the texts and lists of a table are as it says.
    let signature = unsafe { reader.signature(table) };
    match signature {
        Some((signature, shape)) if reader.wrong.is_empty() => {
            let context: *mut &'static str = Box::leak(Box::new(signature.name));
            let host = abi::Host {
                struct_size: size_of::<abi::Host>() as u32,
                abi: abi::VERSION,
                context: context.cast(),
                log: Some(super::instance::log),
            };
            Ok(Declared { table, signature, shape, host })
        }
        _ => Err(reader.wrong),
    }
}

/// What is wrong so far.
struct Reader {
    wrong: Vec<String>,
}

impl Reader {
    fn fault(&mut self, text: String) {
        self.wrong.push(text);
    }

    /// A text of the table, kept once; `None` where there is none.
    ///
    /// # Safety
    /// It is null, or ends with a zero.
    unsafe fn text(&mut self, text: *const c_char, what: &str) -> Option<&'static str> {
        if text.is_null() {
            return None;
        }
        // SAFETY: passed on to the caller.
        match unsafe { CStr::from_ptr(text) }.to_str() {
            Ok(text) => Some(intern(text)),
            Err(_) => {
                self.fault(format!("{what} is no UTF-8"));
                None
            }
        }
    }

    /// A name, which has to be there.
    ///
    /// # Safety
    /// As for `text`.
    unsafe fn name(&mut self, text: *const c_char, what: &str) -> &'static str {
        let before = self.wrong.len();
        // SAFETY: passed on to the caller.
        let name = unsafe { self.text(text, what) }.unwrap_or_default();
        let first = name.chars().next().is_some_and(|first| first.is_ascii_lowercase());
        let fits = |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '_';
        if self.wrong.len() == before && !(first && name.chars().all(fits)) {
            self.fault(format!("{what} is \"{name}\": names have small letters, digits and _, a letter first"));
        }
        name
    }

    /// # Safety
    /// As for [`declared`].
    unsafe fn signature(&mut self, table: &abi::Law) -> Option<(Signature, Shape)> {
        // SAFETY: the caller promises the texts.
        let (name, doc, domain) = unsafe {
            let name = self.name(table.name, "the name of a law");
            (name, self.text(table.doc, "its documentation"), self.text(table.domain, "its domain"))
        };
        let law = if name.is_empty() { "a law" } else { name };
        let shape = match table.shape {
            1 => Some(Shape::Row),
            2 => Some(Shape::Pair),
            3 => Some(Shape::Link),
            4 => Some(Shape::Column),
            other => {
                self.fault(format!("{law} has the shape {other}: 1 rows, 2 pairs, 3 links, 4 columns"));
                None
            }
        };
        if table.precisions & (abi::F32 | abi::F64) == 0 {
            self.fault(format!("{law} takes numbers of no precision: set `precisions` to 1 (float), 2 (double) or 3"));
        }
        for (there, what) in [(table.create.is_some(), "create"), (table.apply.is_some(), "apply")] {
            if !there {
                self.fault(format!("{law} has no function `{what}`"));
            }
        }
        if table.state_size > 0 && (table.save.is_none() || table.load.is_none()) {
            self.fault(format!("{law} has a memory of {} bytes, but not both of `save` and `load`", table.state_size));
        }
        for (size, needed, what) in
            [(table.port_size, PORT_SIZE, "port"), (table.parameter_size, PARAMETER_SIZE, "parameter")]
        {
            if (size as usize) < needed || !(size as usize).is_multiple_of(align_of::<u64>()) {
                let text = format!(
                    "{law}: a {what} has {size} bytes, and {needed} are needed: set `{what}_size` to its sizeof"
                );
                self.fault(text);
                return None;
            }
        }
        for (count, null, what) in [
            (table.port_count, table.ports.is_null(), "ports"),
            (table.parameter_count, table.parameters.is_null(), "parameters"),
        ] {
            if count > MAX_SLOTS || count > 0 && null {
                self.fault(format!("{law} says that it has {count} {what}: there can be {MAX_SLOTS}, in a list"));
                return None;
            }
        }
        // SAFETY: the caller promises the lists, whose members have the sizes that the table says.
        let (ports, parameters, link) =
            unsafe { (self.ports(table, law), self.parameters(table, law), self.link(table, law, shape)) };
        let signature = Signature {
            name,
            doc: doc.unwrap_or_default(),
            domain,
            ports: Box::leak(ports.into_boxed_slice()),
            parameters: Box::leak(parameters.into_boxed_slice()),
            link,
            second_order: table.structure & 1 == 1,
            translation_invariant: false,
            antisymmetric: false,
            estimates: table.structure & 2 != 0 && table.native == abi::NATIVE,
            cutoff: None,
            file: "",
            line: 0,
        };
        Some((signature, shape?))
    }

    /// # Safety
    /// As for [`declared`].
    unsafe fn ports(&mut self, table: &abi::Law, law: &str) -> Vec<Port> {
        let mut ports: Vec<Port> = Vec::new();
        for number in 0..table.port_count {
            let size = table.port_size as usize;
            // SAFETY: the caller promises so many ports of that size, of which zeros are a value.
            let port = unsafe { &copied(table.ports.byte_add(number * size), size) };
            // SAFETY: as above.
            if let Some(port) = unsafe { self.port(port, (number, table.shape), law) } {
                if port.mode.is_input() && ports.last().is_some_and(|last| !last.mode.is_input()) {
                    let property = port.property.name;
                    self.fault(format!(
                        "{law}: {property} is read, and stands behind what is written: inputs come first"
                    ));
                }
                ports.push(port);
            }
        }
        let outputs = ports.iter().filter(|port| !port.mode.is_input()).count();
        if outputs == 0 && self.wrong.is_empty() {
            self.fault(format!(
                "{law} changes nothing: give it a port that it sets, adds to, amends or gives the rate of"
            ));
        }
        let numbers: usize = ports.iter().map(|port| port.property.kind.width()).sum();
        if numbers > MAX_SLOTS {
            self.fault(format!("{law} touches {numbers} numbers of a row: {MAX_SLOTS} are possible"));
        }
        ports
    }

    /// # Safety
    /// As for [`declared`].
    unsafe fn port(&mut self, port: &abi::Port, (number, shape): (usize, u32), law: &str) -> Option<Port> {
        // SAFETY: the caller promises the texts.
        let (name, field, unit, role_of, role_by) = unsafe {
            let name = self.name(port.property, &format!("the property of port {number} of {law}"));
            let field = self.text(port.field, &format!("what {law} calls {name}"));
            let unit = self.text(port.unit, &format!("the unit of {name}"));
            (name, field, unit, self.text(port.role_of, "a role"), self.text(port.role_by, "a role"))
        };
        let kind = match port.kind {
            1 => Some(Kind::Scalar),
            3 => Some(Kind::Vector),
            4 => Some(Kind::Quaternion),
            other => {
                self.fault(format!(
                    "{law}: {name} is of kind {other}: 1 for a number, 3 for a vector, 4 for a quaternion"
                ));
                None
            }
        };
        let mode = match port.mode {
            1 => Some(Mode::Reads),
            2 => Some(Mode::Previous),
            3 => Some(Mode::Sets),
            4 => Some(Mode::Adds),
            5 => Some(Mode::Rates),
            6 => Some(Mode::Amends),
            other => {
                let text = format!(
                    "{law}: {name} has the mode {other}: 1 reads, 2 previous, 3 sets, 4 adds, 5 rates, 6 amends"
                );
                self.fault(text);
                None
            }
        };
        let place = match port.place {
            0 => Some(Place::Own),
            1 => Some(Place::Scene),
            2 => Some(Place::Field),
            3 => Some(Place::End),
            other => {
                self.fault(format!(
                    "{law}: {name} is at place {other}: 0 own rows, 1 scene, 2 field, 3 rows linked to"
                ));
                None
            }
        };
        let (kind, mode, place) = (kind?, mode?, place?);
        let property = self.property(port, (name, kind, unit), mode, [role_of, role_by], law)?;
        if matches!(place, Place::Scene | Place::Field) && !mode.is_input() {
            let what = if place == Place::Scene { "constant of the scene" } else { "field" };
            self.fault(format!("{law} {} {name}, which is a {what}: it may be read", mode.does()));
        }
        if place == Place::End && shape != 3 {
            self.fault(format!(
                "{law}: {name} is of rows linked to, and only a law of links has those: set `shape` to 3"
            ));
        }
        if port.has_default != 0 && place != Place::Scene {
            self.fault(format!("{law}: {name} has a default, which only a constant of the scene can have (`place` 1)"));
        }
        Some(Port {
            field: field.unwrap_or(name),
            property,
            mode,
            place,
            optional: port.optional != 0,
            default: (port.has_default != 0).then_some(port.default_value),
            from: if port.from == 0 { u64::MAX } else { port.from },
        })
    }

    fn property(
        &mut self,
        port: &abi::Port,
        (name, kind, unit): (&'static str, Kind, Option<&'static str>),
        mode: Mode,
        [role_of, role_by]: [Option<&'static str>; 2],
        law: &str,
    ) -> Option<PropertyInfo> {
        let dimension = Dimension::new(port.si);
        let standard = STANDARD_PROPERTIES.iter().find(|known| known.name == name);
        let text = match (unit, standard) {
            (Some(unit), _) => unit,
            (None, Some(standard)) if standard.size.dimension == dimension => standard.unit,
            _ if dimension == Dimension::NONE => "",
            _ => intern(&dimension.to_string()),
        };
        let size = match Unit::parse(text) {
            Ok(size) => size,
            Err(error) => {
                self.fault(format!("{law}: the unit of {name}: {}", error.message(text)));
                return None;
            }
        };
        if size.dimension != dimension {
            let text = format!(
                "{law}: {name} is in {text}, but its exponents `si` (of m, kg, s, A, K, mol, cd) say {}: for {text} they are {:?}",
                said(dimension),
                size.dimension.exponents()
            );
            self.fault(text);
            return None;
        }
        if let Some(standard) = standard
            && (standard.kind != kind || standard.size != size)
        {
            let (found, own) = (PropertyInfo { name, kind, unit: text, size, role: Role::Plain }, standard.measured());
            let text = format!("{law} {} {name} as a {}, but it is a {own}", mode.does(), found.measured());
            self.fault(text);
            return None;
        }
        let of = |reader: &mut Self| {
            if role_of.is_none() {
                reader.fault(format!("{law}: the role of {name} is of nothing: set `role_of`"));
            }
            role_of.unwrap_or_default()
        };
        let role = match port.role {
            0 => match (standard, mode) {
                (Some(standard), _) => standard.role,
                (None, Mode::Adds) => Role::Sum { start: None },
                _ => Role::Plain,
            },
            1 => Role::Plain,
            2 => Role::Coordinate,
            3 => Role::Momentum(of(self)),
            4 => Role::Sum { start: role_of },
            5 => {
                if role_by.is_none() {
                    self.fault(format!("{law}: {name} is a turn by nothing: set `role_by`"));
                }
                Role::Turn { of: of(self), by: role_by.unwrap_or_default() }
            }
            6 => Role::Switch,
            other => {
                self.fault(format!("{law}: {name} has the role {other}: 0 to 6 are known"));
                return None;
            }
        };
        Some(PropertyInfo { name, kind, unit: text, size, role })
    }

    /// # Safety
    /// As for [`declared`].
    unsafe fn parameters(&mut self, table: &abi::Law, law: &str) -> Vec<Parameter> {
        let mut parameters = Vec::new();
        for number in 0..table.parameter_count {
            // SAFETY: the caller promises so many parameters of that size, and their texts.
            let (parameter, name, doc, unit) = unsafe {
                let size = table.parameter_size as usize;
                let parameter = copied(table.parameters.byte_add(number * size), size);
                let name = self.name(parameter.name, &format!("parameter {number} of {law}"));
                let doc = self.text(parameter.doc, "its documentation");
                let unit = self.text(parameter.unit, "its unit");
                (parameter, name, doc, unit)
            };
            let unit = unit.unwrap_or_default();
            if let Err(error) = Unit::parse(unit) {
                self.fault(format!("{law}: the unit of parameter {name}: {}", error.message(unit)));
            }
            if parameter.width != 1 && parameter.width != 3 {
                self.fault(format!(
                    "{law}: parameter {name} has the width {}: 1 for a number, 3 for a vector",
                    parameter.width
                ));
            }
            parameters.push(Parameter {
                name,
                doc: doc.unwrap_or_default(),
                unit,
                width: parameter.width as usize,
                default: (parameter.has_default != 0).then_some(parameter.default_value),
            });
        }
        parameters
    }

    /// # Safety
    /// As for [`declared`].
    unsafe fn link(&mut self, table: &abi::Law, law: &str, shape: Option<Shape>) -> Option<PropertyInfo> {
        if table.link.is_null() {
            if shape == Some(Shape::Link) {
                self.fault(format!("{law} is a law of links, and follows none: set `link`"));
            }
            return None;
        }
        // SAFETY: passed on to the caller.
        let name = unsafe { self.name(table.link, &format!("the link of {law}")) };
        let arity = table.link_arity as usize;
        if !(1..=16).contains(&arity) {
            self.fault(format!("{law}: a link joins {arity} rows: set `link_arity` to 1 to 16"));
        }
        Some(PropertyInfo { name, kind: Kind::Link(arity), unit: "", size: Unit::ONE, role: Role::Plain })
    }
}

fn said(dimension: Dimension) -> String {
    if dimension == Dimension::NONE { "no unit".to_owned() } else { dimension.to_string() }
}
