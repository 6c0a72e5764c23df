//! From a scene to an engine, or to everything that is wrong with it.
//!
//! In: a [`Scene`], which knows no property and no law. Out: an [`Engine`] in any precision, or [`SceneFault`]s at
//! their places: what the scene's names do not mean, and what the library finds wrong with the rest. Never: a step.

pub mod integrators;
mod laws;
mod places;
pub mod properties;

use vesper::field;
use vesper::law::Signature;
use vesper::prelude::*;
use vesper::registry::Backend;
use vesper_laws::catalog::CatalogPrecision;

use crate::fault::{SceneFault, Span, Spanned, help_for};
use crate::modules::Modules;
use crate::scene::{BackendChoice, ColumnData, DomainData, FieldData, FieldShape, Parameter, Scene};
use integrators::NamedIntegrator;
use laws::factor;

/// More threads than this are a slip of the finger.
const MOST_THREADS: usize = 1024;

/// The engine of a scene, at the scene's start.
///
/// # Errors
/// Everything that is wrong with the scene, in the order of its text.
pub fn engine<P: CatalogPrecision>(scene: &Scene) -> Result<Engine<P>, Vec<SceneFault>> {
    builder(scene)?.build().map_err(|faults| run_faults(scene, &faults))
}

/// The builder of a scene, for whoever changes something of it.
///
/// # Errors
/// What the scene's names do not mean, and values that do not fit them, in the order of its text.
pub fn builder<P: CatalogPrecision>(scene: &Scene) -> Result<Builder<P>, Vec<SceneFault>> {
    extended(scene, Engine::builder())
}

/// What a scene says, added to a builder that may have something already.
///
/// # Errors
/// As [`builder`].
pub fn extended<P: CatalogPrecision>(scene: &Scene, builder: Builder<P>) -> Result<Builder<P>, Vec<SceneFault>> {
    let mut notes = Notes::of(scene);
    let builder = notes.builder(builder);
    if notes.count() == 0 { Ok(builder) } else { Err(notes.into_faults()) }
}

/// What a scene's names do not mean, and values that do not fit them, each with its place: all that can be found without
/// an engine, so also where parts of the scene could not be read. Its modules may come from where `modules` says.
pub fn names(scene: &Scene, modules: &Modules) -> Vec<(Span, SceneFault)> {
    let mut notes = Notes { modules, ..Notes::of(scene) };
    _ = notes.builder::<f64>(Engine::builder());
    notes.faults
}

/// Laws that sleep by mistake. A scene may list laws that lack their data; but where none runs at all nothing moves, and
/// a name near the one that a law lacks, which no law knows, is most likely a slip.
pub fn asleep(scene: &Scene, report: &Report) -> Vec<SceneFault> {
    let mut notes = Notes::of(scene);
    let none_runs = !report.laws.iter().any(|law| matches!(law.status, Status::Active { .. }));
    for (law, why) in report.dormant() {
        let slip = |missing: &&vesper::registry::Missing| {
            missing.starved_by.is_empty() && missing.nearest.as_ref().is_some_and(|near| is_slip(scene, near))
        };
        let slip = why.missing.iter().find(slip).and_then(|missing| missing.nearest.as_deref());
        let span = slip.and_then(|near| places::column_of(scene, &law.domain, near));
        let span = span.or_else(|| places::law_name(scene, &law.label));
        // One slip may put several laws to sleep, and is one mistake.
        let new = span.filter(|span| !notes.faults.iter().any(|(known, _)| known == span));
        if let (true, Some(span)) = (slip.is_some() || none_runs, new) {
            let help = match slip {
                Some(_) => "no law knows this name; a law that may sleep is listed with `enabled = false`",
                None => "no law of the scene runs; `vesper explain` tells what each needs",
            };
            notes.fault(span, law.to_string(), Some(help.to_owned()));
        }
    }
    notes.into_faults()
}

/// Whether the scene has `name` as a column, constant or field that no law and no standard property knows.
fn is_slip(scene: &Scene, name: &str) -> bool {
    properties::known(name).is_none() && places::column_of(scene, "", name).is_some()
}

/// Faults of a running engine, in the scene's words.
pub fn run_faults(scene: &Scene, faults: &Faults) -> Vec<SceneFault> {
    let mut notes = Notes::of(scene);
    faults.iter().for_each(|fault| notes.library_fault(fault));
    notes.into_faults()
}

/// What a law of the scene means by `name`.
pub fn law_of(scene: &Scene, name: &str) -> Option<&'static Signature> {
    let request = scene.laws.iter().find(|law| law.called() == name || law.name.value == name)?;
    laws::find(&Notes::of(scene), request).ok().map(|law| law.signature())
}

/// The faults found so far.
struct Notes<'s> {
    scene: &'s Scene,
    modules: &'s Modules,
    faults: Vec<(Span, SceneFault)>,
}

impl<'s> Notes<'s> {
    fn of(scene: &'s Scene) -> Self {
        Notes { scene, modules: &scene.modules, faults: Vec::new() }
    }

    /// The property that is known by `name`: a standard one, or one that a stock law, or a law of the scene, declares.
    fn known(&self, name: &str) -> Option<PropertyInfo> {
        let of_modules = || self.scene.laws.iter().filter(|law| law.module.is_some());
        let laws = || of_modules().filter_map(|law| laws::find(self, law).ok()).map(|law| law.signature());
        let declared = || laws().flat_map(|law| law.ports.iter().map(|port| port.property).chain(law.link));
        properties::known(name).or_else(|| declared().find(|property| property.name == name))
    }
}

impl Notes<'_> {
    fn fault(&mut self, span: Span, text: impl Into<String>, help: Option<String>) {
        let fault = self.scene.fault(span, text, help);
        self.faults.push((span, fault));
    }

    fn wrong<T>(&mut self, span: Span, text: impl Into<String>) -> Option<T> {
        self.fault(span, text, None);
        None
    }

    fn count(&self) -> usize {
        self.faults.len()
    }

    fn library_fault(&mut self, fault: &Fault) {
        match places::placed(self.scene, fault) {
            (Some(span), text, help) => self.fault(span, text, help),
            (None, text, help) => {
                let fault = SceneFault { help, ..self.scene.fault_of_file(text) };
                self.faults.push((Span { start: usize::MAX, end: usize::MAX }, fault));
            }
        }
    }

    /// The faults by their places; of several at one place that say the same, one.
    fn into_faults(mut self) -> Vec<SceneFault> {
        self.faults.sort_by_key(|(span, _)| *span);
        self.faults.dedup_by(|b, a| a == b);
        self.faults.into_iter().map(|(_, fault)| fault).collect()
    }

    /// Adds to a builder what is right of the scene.
    fn builder<P: CatalogPrecision>(&mut self, builder: Builder<P>) -> Builder<P> {
        let scene = self.scene;
        let mut constants = Domain::new(vesper::domain::SCENE);
        for constant in &scene.constants {
            constants = self.constant(constants, constant);
        }
        let mut builder = builder.domain(constants);
        for data in &scene.domains {
            let mut domain = Domain::new(&data.name.value);
            if let Some(rows) = data.rows() {
                domain = domain.rows(rows);
            }
            for column in &data.columns {
                domain = self.column(domain, data, column);
            }
            builder = builder.domain(domain);
        }
        for data in &scene.fields {
            builder = self.field(builder, data);
        }
        for request in &scene.laws {
            if let Some((compiled, options)) = laws::law::<P>(self, request) {
                builder = builder.listed(compiled, options);
            }
        }
        self.settings(builder)
    }

    /// The property of a column of `width` numbers in `unit`, which it must fit.
    fn property(
        &mut self,
        (name, width): (&str, usize),
        unit: Option<&Spanned<String>>,
        span: Span,
    ) -> Option<PropertyInfo> {
        let Some(property) = self.known(name) else {
            let made = properties::unknown(name, width, unit.map(|unit| unit.value.as_str()));
            return made.map_err(|text| self.fault(span, text, None)).ok();
        };
        let before = self.count();
        if property.kind.width() != width {
            let components = |n| if n == 1 { "a number".to_owned() } else { format!("{n} numbers") };
            let text = format!(
                "`{name}` is a {}: expected {}, found {width}",
                property.kind,
                components(property.kind.width())
            );
            self.fault(span, text, None);
        }
        if let Some(unit) = unit {
            factor(self, unit, property.unit);
        }
        (self.count() == before).then_some(property)
    }

    fn constant<P: CatalogPrecision>(&mut self, domain: Domain<P>, constant: &Parameter) -> Domain<P> {
        let (name, width) = (constant.name.value.as_str(), constant.value.len());
        let Some(property) = self.property((name, width), constant.unit.as_ref(), constant.value_span) else {
            return domain;
        };
        let unit = constant.unit.as_ref().map(|unit| unit.value.as_str());
        domain.with_column(property, unit, None, Values::new(width, constant.value.clone()))
    }

    fn column<P: CatalogPrecision>(&mut self, domain: Domain<P>, data: &DomainData, column: &ColumnData) -> Domain<P> {
        let name = column.name.value.as_str();
        let known = self.known(name);
        if let Some(target) = &column.link {
            return self.link(domain, data, column, known, target);
        }
        if let Some(Kind::Link(_)) = known.map(|property| property.kind) {
            let help = "write { domain = \"..\", value = [..] }".to_owned();
            self.fault(column.span, format!("`{name}` names rows of a domain, and does not say of which"), Some(help));
            return domain;
        }
        // A column without rows fits any width.
        let any = known.map(|property| property.kind.width()).filter(|_| column.values.is_empty());
        let width = any.unwrap_or(column.width);
        let Some(property) = self.property((name, width), column.unit.as_ref(), column.row_span(0)) else {
            return domain;
        };
        let unit = column.unit.as_ref().map(|unit| unit.value.as_str());
        let rows = |subset: &Vec<Spanned<usize>>| -> Option<Vec<u32>> {
            subset.iter().map(|row| u32::try_from(row.value).ok()).collect()
        };
        let subset = match column.subset.as_ref().map(rows) {
            Some(None) => {
                self.fault(column.span, format!("a row number is above {}", u32::MAX), None);
                return domain;
            }
            Some(rows) => rows,
            None => None,
        };
        domain.with_column(property, unit, subset, Values::new(width, column.values.clone()))
    }

    fn link<P: CatalogPrecision>(
        &mut self,
        domain: Domain<P>,
        data: &DomainData,
        column: &ColumnData,
        known: Option<PropertyInfo>,
        target: &Spanned<String>,
    ) -> Domain<P> {
        let name = column.name.value.as_str();
        let property = match known.map_or_else(|| properties::unknown_link(name, column.width), Ok) {
            Ok(property) => property,
            Err(text) => {
                self.fault(column.span, text, None);
                return domain;
            }
        };
        match property.kind {
            Kind::Link(arity) if arity != column.width && column.rows > 0 => {
                let text = format!("`{name}` names {arity} rows in each item, and here {}", column.width);
                self.fault(column.row_span(0), text, None);
                return domain;
            }
            Kind::Link(_) => {}
            kind => {
                self.fault(target.span, format!("`{name}` is a {kind}, which names no rows of a domain"), None);
                return domain;
            }
        }
        if column.subset.is_some() {
            let text = format!("`{name}` needs rows for every row of `{}`", data.name.value);
            self.fault(column.span, text, Some("leave `rows` out".to_owned()));
            return domain;
        }
        // Rows are checked to exist when the scene is read, so each fits, and to be whole and not negative.
        domain.with_link(property, &target.value, column.values.iter().map(|&row| row as u32).collect())
    }

    fn field<P: CatalogPrecision>(&mut self, builder: Builder<P>, data: &FieldData) -> Builder<P> {
        let name = data.name.value.as_str();
        let unit = data.unit.as_ref().map(|unit| unit.value.as_str());
        let property = match self.known(name).map_or_else(|| properties::unknown(name, 3, unit), Ok) {
            Ok(property) => property,
            Err(text) => {
                self.fault(data.name.span, text, None);
                return builder;
            }
        };
        if property.kind != Kind::Vector {
            let text = format!("`{name}` is a {}, and a field has a vector at every place", property.kind);
            self.fault(data.name.span, text, None);
            return builder;
        }
        let scale = data.unit.as_ref().map_or(1.0, |unit| factor(self, unit, property.unit));
        let mut vector = |value: &[f64]| match *value {
            [x, y, z] => [x * scale, y * scale, z * scale],
            _ => {
                self.fault(data.shape_span, format!("`{name}` is a vector: expected 3 numbers, found 1"), None);
                [0.0; 3]
            }
        };
        match &data.shape {
            FieldShape::Uniform(value) => builder.field(property, field::Uniform { value: vector(value) }),
            FieldShape::Boxes(boxes) => {
                let one = |part: &crate::scene::FieldBox| field::FieldBox {
                    min: part.min,
                    max: part.max,
                    value: vector(&part.value),
                };
                builder.field(property, field::Boxes { boxes: boxes.iter().map(one).collect() })
            }
            FieldShape::Point { at, strength } => {
                builder.field(property, field::Point { at: *at, strength: strength * scale })
            }
            FieldShape::Dipole { at, moment } => {
                builder.field(property, field::Dipole { at: *at, moment: moment.map(|component| component * scale) })
            }
        }
    }

    fn backend(&mut self, choice: Option<&Spanned<BackendChoice>>) -> Option<Backend> {
        let Some(choice) = choice else { return Some(Backend::Auto) };
        let backend = laws::backend(choice.value);
        if backend.is_none() {
            let help = "use auto, cpu or parallel, or build it with the feature `gpu`".to_owned();
            self.fault(choice.span, "this build has no GPU backend", Some(help));
        }
        backend
    }

    /// Faults an option of an integrator that it does not have, or a value that it cannot take.
    fn integrator_option(&mut self, known: &NamedIntegrator, option: &Parameter) {
        let name = option.name.value.as_str();
        if !known.options.contains(&name) {
            let help = match known.options {
                [] => None,
                options => help_for(name, options.iter().copied()),
            };
            return self.fault(option.name.span, format!("`{}` has no option `{name}`", known.name), help);
        }
        match option.value[..] {
            [value] if value > 0.0 && value.is_finite() || name == "atol" && value == 0.0 => {}
            _ => self.fault(option.value_span, format!("expected a number above 0 for `{name}`"), None),
        }
    }

    /// Integrator, step, backend, threads, strictness, observers.
    fn settings<P: CatalogPrecision>(&mut self, mut builder: Builder<P>) -> Builder<P> {
        let scene = self.scene;
        let engine = &scene.engine;
        if let Some(choice) = &engine.integrator {
            let name = choice.name.value.as_str();
            match integrators::integrator(name) {
                Some(known) => {
                    choice.options.iter().for_each(|option| self.integrator_option(known, option));
                    let given = |wanted: &str| choice.options.iter().find(|option| option.name.value == wanted);
                    let value = |wanted: &str, usual: f64| given(wanted).map_or(usual, |option| option.value[0]);
                    builder = builder.boxed_integrator((known.make)(&value));
                }
                None => {
                    self.fault(choice.name.span, format!("no integrator is named `{name}`"), integrators::help(name));
                }
            }
        }
        let adaptive = engine.integrator.as_ref().is_some_and(|choice| integrators::is_adaptive(&choice.name.value));
        // An adaptive integrator begins with the step of the scene, but it finds a better one than the frame by itself.
        if let Some(step) = engine.step.as_ref().or(engine.frame.as_ref().filter(|_| !adaptive)) {
            builder = builder.step(step.value);
        }
        if engine.compensated.as_ref().is_some_and(|compensated| compensated.value) {
            builder = builder.compensated();
        }
        if let Some(estimates) = &engine.estimates {
            builder = builder.estimates(estimates.value);
        }
        if engine.across_jumps.as_ref().is_some_and(|across| across.value) {
            builder = builder.across_jumps();
        }
        if engine.moving_origin.as_ref().is_some_and(|moving| moving.value) {
            builder = builder.moving_origin(Position);
        }
        if engine.backend.is_some()
            && let Some(backend) = self.backend(engine.backend.as_ref())
        {
            builder = builder.backend(backend);
        }
        match &engine.threads {
            Some(threads) if threads.value > MOST_THREADS => {
                let text = format!("expected at most {MOST_THREADS} threads, found {}", threads.value);
                self.fault(threads.span, text, None);
            }
            Some(threads) => builder = builder.threads(threads.value),
            None => {}
        }
        if engine.strict.as_ref().is_some_and(|strict| strict.value) {
            builder = builder.strict();
        }
        for entry in engine.observe.iter().flatten() {
            let Some((domain, name)) = entry.value.split_once('.') else { continue };
            match self.known(name).map_or_else(|| properties::unknown(name, 1, None), Ok) {
                Ok(property) => builder = builder.observe(domain, property),
                Err(text) => self.fault(entry.span, text, None),
            }
        }
        builder
    }
}
