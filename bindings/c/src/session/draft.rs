//! An engine of one precision that is being put together by names.
//!
//! In: domains, columns, memory, pieces of scenes, one after the other. Out: a [`Run`]. Every fault is given at once, and kept:
//! a client that looks at nothing but the end finds them all there. Never: an engine that lacks what was refused.

use super::lending::{LentColumn, OfWidth, Taken, overlap};
use super::names::{self, Named};
use super::run::{Run, Settings};
use super::{Memory, Numbers, Trouble, texts};
use core::ptr::NonNull;
use std::path::Path;
use vesper::backend::Compile;
use vesper::domain::SCENE;
use vesper::error::nearest;
use vesper::prelude::*;
use vesper::registry::{Options, Status};
use vesper_cli::assemble::{self, properties};
use vesper_cli::modules::Modules;
use vesper_cli::scene::Scene;

/// One domain so far.
#[derive(Debug)]
struct Part<P: Precision> {
    name: String,
    rows: usize,
    domain: Domain<P>,
    properties: Vec<PropertyInfo>,
}

impl<P: Precision> Part<P> {
    fn new(name: &str, rows: usize) -> Self {
        Part { name: name.to_owned(), rows, domain: Domain::new(name).rows(rows), properties: Vec::new() }
    }

    fn add(&mut self, property: PropertyInfo, add: impl FnOnce(Domain<P>) -> Domain<P>) -> Result<(), Trouble> {
        if self.properties.iter().any(|known| known.name == property.name) {
            return Err(Trouble::fault(format!("{}.{} is given twice: keep one", self.name, property.name)));
        }
        self.properties.push(property);
        let domain = core::mem::replace(&mut self.domain, Domain::new(&self.name));
        self.domain = add(domain);
        Ok(())
    }
}

/// All that was given so far.
#[derive(Debug)]
pub(super) struct Draft<P: Precision> {
    /// The first one is "scene", of one row.
    parts: Vec<Part<P>>,
    /// A whole scene, or pieces of one.
    scenes: Vec<Scene>,
    /// The whole scene among them.
    whole: Option<usize>,
    /// Laws of the client.
    made: Vec<(DynLaw, Options)>,
    lent: Vec<LentColumn<P>>,
    /// Where modules of laws may come from.
    modules: Modules,
    faults: Vec<String>,
}

impl<P: Precision> Draft<P> {
    pub(super) fn new() -> Self {
        let parts = vec![Part::new(SCENE, 1)];
        Draft {
            parts,
            scenes: Vec::new(),
            whole: None,
            made: Vec::new(),
            lent: Vec::new(),
            modules: Modules::default(),
            faults: Vec::new(),
        }
    }

    /// Runs a call, and keeps what is wrong with it.
    pub(super) fn noted(&mut self, call: impl FnOnce(&mut Self) -> Result<(), Trouble>) -> Result<(), Trouble> {
        let done = call(self);
        if let Err(trouble) = &done {
            self.faults.push(trouble.to_string());
        }
        done
    }

    /// The names of all domains but "scene", each once.
    fn domains(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.parts.iter().skip(1).map(|part| part.name.as_str()).collect();
        for domain in self.scenes.iter().flat_map(|scene| &scene.domains) {
            let name = domain.name.value.as_str();
            if !names.contains(&name) && name != SCENE {
                names.push(name);
            }
        }
        names
    }

    fn part(&mut self, name: &str) -> Result<&mut Part<P>, Trouble> {
        let Some(place) = self.parts.iter().position(|part| part.name == name) else {
            let near = nearest(name, self.parts.iter().map(|part| part.name.as_str()));
            let mend =
                near.map_or(": say it first, with its rows".to_owned(), |near| format!("; did you mean {near}?"));
            return Err(Trouble::fault(format!("domain {name} does not exist{mend}")));
        };
        Ok(&mut self.parts[place])
    }

    pub(super) fn domain(&mut self, name: &str, rows: usize) -> Result<(), Trouble> {
        if u32::try_from(rows).is_err() {
            let text = format!("domain {name} has {rows} rows: at most {} can be numbered", u32::MAX);
            return Err(Trouble::fault(text));
        }
        if name.is_empty() {
            return Err(Trouble::fault("a domain has no name: give it one"));
        }
        if name == SCENE {
            return Err(Trouble::fault(
                "domain scene has always one row, which holds the constants: it is there already",
            ));
        }
        if self.domains().contains(&name) {
            return Err(Trouble::fault(format!("domain {name} is given twice: keep one")));
        }
        self.parts.push(Part::new(name, rows));
        Ok(())
    }

    pub(super) fn column(&mut self, domain: &str, property: &str, numbers: Numbers<'_>) -> Result<(), Trouble> {
        let part = self.part(domain)?;
        if let Numbers::Rows(_) = numbers {
            let text =
                format!("{domain}.{property} is given in u32, which are rows: give it in f32 or f64, or as a link");
            return Err(Trouble::Argument(text));
        }
        let Named { info, unit } = names::column(domain, property, numbers.len(), part.rows)?;
        let values = Values::new(info.kind.width(), numbers.each().collect());
        part.add(info, |domain| domain.with_column(info, unit, None, values))
    }

    pub(super) fn link(&mut self, domain: &str, name: &str, target: &str, rows: &[u32]) -> Result<(), Trouble> {
        let part = self.part(domain)?;
        let info = names::link(domain, name, rows.len(), part.rows)?;
        part.add(info, |domain| domain.with_link(info, target, rows.to_vec()))
    }

    /// Lends `count` numbers from `start` on to a column.
    ///
    /// # Safety
    /// As for [`Assembly::lend`](super::Assembly::lend).
    pub(super) unsafe fn lend(
        &mut self,
        domain: &str,
        property: &str,
        (start, count): (NonNull<P>, usize),
    ) -> Result<(), Trouble> {
        if !start.is_aligned() {
            let text = format!("{domain}.{property}: {start:p} is no address of an {}: align the memory", P::NAME);
            return Err(Trouble::Argument(text));
        }
        let first = start.addr().get();
        let last = count.checked_mul(size_of::<P>()).and_then(|bytes| first.checked_add(bytes));
        let Some(last) = last.filter(|last| isize::try_from(last - first).is_ok()) else {
            let text =
                format!("{domain}.{property}: no memory has {count} numbers behind {start:p}: say how many there are");
            return Err(Trouble::Argument(text));
        };
        let bytes = first..last;
        let shared = self.lent.iter().find(|other| overlap(other.taken.bytes(), &bytes));
        let shared = shared.map(|other| format!("{}.{}", other.domain, other.property));
        let part = self.part(domain)?;
        let Named { info, unit } = names::column(domain, property, count, part.rows)?;
        let name = info.name;
        let refused = |why: String| Trouble::fault(format!("{domain}.{name} cannot be lent: {why}"));
        if domain == SCENE {
            return Err(refused("constants do not change while laws run: give the value".to_owned()));
        }
        if names::factor(domain, &info, unit)? != 1.0 {
            let text = format!("it is used as it is, in {}: convert the numbers, or have them copied", info.unit);
            return Err(refused(text));
        }
        if let Some(other) = shared {
            return Err(refused(format!("{other} has some of the same memory: lend each column memory of its own")));
        }
        let Some(taken) = Taken::new(bytes) else {
            return Err(refused("another engine has some of this memory: close or free that one first".to_owned()));
        };
        // SAFETY: the caller promised this many numbers from `start` on, and `column` that they are all the rows' numbers.
        let Some(memory) = (unsafe { OfWidth::new(start, part.rows, info.kind.width()) }) else {
            return Err(refused(format!("it is a {}", info.kind)));
        };
        part.add(info, |domain| memory.lend(domain, info))?;
        self.lent.push(LentColumn { domain: domain.to_owned(), property: name, memory, taken });
        Ok(())
    }

    pub(super) fn laws_from(&mut self, folder: &Path) -> Result<(), Trouble> {
        if !folder.is_dir() {
            return Err(Trouble::fault(format!("there is no folder {} with modules of laws", folder.display())));
        }
        self.modules = self.modules.and(folder);
        Ok(())
    }

    pub(super) fn law(&mut self, name: &str, text: &str) -> Result<(), Trouble> {
        let scene = texts::law::<P>(name, text, &self.domains(), &self.modules)?;
        self.scenes.push(scene);
        Ok(())
    }

    pub(super) fn made_law(&mut self, law: DynLaw, options: Options) {
        self.made.push((law, options));
    }

    /// What is meant by a name: a property that laws know, one that a column was given of, or a new one of this width.
    pub(super) fn property(&self, text: &str, width: usize) -> Result<PropertyInfo, Trouble> {
        let (name, unit) = names::apart(text)?;
        let given = || self.parts.iter().flat_map(|part| &part.properties).find(|info| info.name == name).copied();
        let in_scene = || {
            let columns = self.scenes.iter().flat_map(|scene| &scene.domains).flat_map(|domain| &domain.columns);
            let column = columns.into_iter().find(|column| column.name.value == name)?;
            properties::unknown(name, column.width, column.unit.as_ref().map(|unit| unit.value.as_str())).ok()
        };
        match properties::known(name).or_else(given).or_else(in_scene) {
            Some(info) => Ok(info),
            None => properties::unknown(name, width, unit).map_err(|why| Trouble::fault(format!("{name}: {why}"))),
        }
    }

    pub(super) fn settings(&mut self, text: &str) -> Result<(), Trouble> {
        let scene = texts::settings::<P>(text, &self.domains())?;
        self.scenes.push(scene);
        Ok(())
    }

    pub(super) fn scene(&mut self, text: &str, folder: &Path) -> Result<(), Trouble> {
        if self.whole.is_some() {
            return Err(Trouble::fault("a scene is given twice: keep one, and give the rest in pieces"));
        }
        let scene = texts::scene::<P>(text, folder, &self.modules)?;
        let known = self.domains();
        let twice = scene.domains.iter().find(|domain| known.contains(&domain.name.value.as_str()));
        if let Some(domain) = twice {
            let text = format!("domain {} is given twice: keep one", domain.name.value);
            return Err(vec![scene.fault(domain.name.span, text, None)].into());
        }
        self.whole = Some(self.scenes.len());
        self.scenes.push(scene);
        Ok(())
    }

    pub(super) fn build(self) -> Result<Run<P>, Trouble> {
        if !self.faults.is_empty() {
            return Err(Trouble::Fault(self.faults.join("\n")));
        }
        let mut builder = Engine::<P>::builder();
        for part in self.parts {
            builder = builder.domain(part.domain);
        }
        for scene in &self.scenes {
            builder = assemble::extended(scene, builder)?;
        }
        for (law, options) in self.made {
            builder = builder.listed(law.compile::<P>(), options);
        }
        let whole = self.whole.map(|place| &self.scenes[place]);
        let engine = builder.build().map_err(|faults| match whole {
            Some(scene) => assemble::run_faults(scene, &faults).into(),
            None => Trouble::from(faults),
        })?;
        if let Some(scene) = whole {
            let asleep = assemble::asleep(scene, engine.report());
            if !asleep.is_empty() {
                return Err(asleep.into());
            }
        }
        awake(engine.report())?;
        let settings = self.scenes.iter().fold(Settings::default(), Settings::and);
        Ok(Run::new(engine, self.lent, settings))
    }
}

/// Laws that sleep by mistake, as in scenes: where none runs at all nothing moves, and a name near the one that a law lacks,
/// which no law knows, is most likely a slip.
fn awake(report: &Report) -> Result<(), Trouble> {
    let none_runs = !report.laws.iter().any(|law| matches!(law.status, Status::Active { .. }));
    let asleep = report.dormant().filter(|(_, why)| {
        let slip = why.missing.iter().filter(|missing| missing.starved_by.is_empty());
        let mut near = slip.filter_map(|missing| missing.nearest.as_deref());
        none_runs || near.any(|near| properties::known(near).is_none())
    });
    let texts: Vec<String> = asleep.map(|(law, _)| law.to_string()).collect();
    if texts.is_empty() { Ok(()) } else { Err(Trouble::Fault(texts.join("\n"))) }
}

/// Where memory of this precision begins, and how many numbers it holds; trouble where it is of the other one.
pub(super) fn in_precision<P: Precision>(memory: Memory, what: &str) -> Result<(NonNull<P>, usize), Trouble> {
    let (start, count, given) = match memory {
        Memory::F32(start, count) => (start.cast::<P>(), count, "f32"),
        Memory::F64(start, count) => (start.cast::<P>(), count, "f64"),
    };
    if given == P::NAME {
        return Ok((start, count));
    }
    let text = format!("{what} cannot be lent: it is in {given}, and the engine in {}; have it copied", P::NAME);
    Err(Trouble::Argument(text))
}
