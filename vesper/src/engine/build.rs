//! From domains, fields and laws to an engine, or to everything that is wrong with them.

use super::machine::machine;
use super::{Clock, Engine, FixedStep};
use crate::backend::{Compile, Compiled};
use crate::column::Values;
use crate::domain::{AsProperty, Domain, SCENE};
use crate::error::{Fault, Faults, nearest};
use crate::field::Field;
use crate::integrate::{Integrator, Leapfrog};
use crate::pipeline::{Chain, Chained, Listed, Machine, Pipeline, Settings};
use crate::property::PropertyInfo;
use crate::real::{Isa, Scalar, compiled_here};
use crate::registry::{Backend, Entry, Options, Report, Status};
use crate::state::{Origin, State};
use std::sync::Arc;

/// A law as it can be listed: a law, or a law with options.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be listed as a law",
    note = "it needs `#[derive(Law)]` and a `#[kernel]`; parameters are given in f64"
)]
pub trait Listing {
    /// The law with its loops.
    fn compiled<P: Scalar>(&self) -> Compiled<P>;
    /// How it is used.
    fn options(&self) -> Options;
}

impl<L: Compile> Listing for L {
    fn compiled<P: Scalar>(&self) -> Compiled<P> {
        self.compile()
    }
    fn options(&self) -> Options {
        Options::default()
    }
}

/// A law with options; made by the methods of [`Configure`].
#[derive(Clone, Debug)]
pub struct Configured<L> {
    law: L,
    options: Options,
}

impl<L: Compile> Listing for Configured<L> {
    fn compiled<P: Scalar>(&self) -> Compiled<P> {
        self.law.compile()
    }
    fn options(&self) -> Options {
        self.options.clone()
    }
}

impl<L> Configured<L> {
    fn with(mut self, change: impl FnOnce(&mut Options)) -> Self {
        change(&mut self.options);
        self
    }

    /// Stands on this domain.
    #[must_use]
    pub fn on(self, domain: &str) -> Self {
        self.with(|options| options.domain = Some(domain.to_owned()))
    }

    /// Has this name of its own.
    #[must_use]
    pub fn label(self, label: &str) -> Self {
        self.with(|options| options.label = Some(label.to_owned()))
    }

    /// Is evaluated on every n-th step, and held between.
    #[must_use]
    pub fn every(self, steps: u32) -> Self {
        self.with(|options| options.every = steps)
    }

    /// Runs there.
    #[must_use]
    pub fn backend(self, backend: Backend) -> Self {
        self.with(|options| options.backend = backend)
    }

    /// Sums far rows together, with a relative error of each row's sum whose root mean square is this one: measured for a sample
    /// of rows in the engine's first evaluation, and then shown by `Engine::explain`. For laws that say `inverse_square`, as gravity
    /// does; few rows, which all pairs are faster for, are not touched.
    ///
    /// Another engine that goes on from a checkpoint measures anew: it has the same error, but not the same bits. Derivatives, which
    /// implicit integrators and stable steps need, are of all pairs.
    #[must_use]
    pub fn far_field(self, error: f64) -> Self {
        self.with(|options| options.far_field = Some(error))
    }

    /// Is switched off at first.
    #[must_use]
    pub fn off(self) -> Self {
        self.with(|options| options.enabled = false)
    }

    /// Must run: dormancy is a fault.
    #[must_use]
    pub fn required(self) -> Self {
        self.with(|options| options.required = true)
    }
}

/// Options of a law, written behind it: `Gravity::default().on("stars").every(4)`.
pub trait Configure: Compile + Sized {
    /// The law with options, none set.
    fn configured(self) -> Configured<Self> {
        Configured { law: self, options: Options::default() }
    }
    /// Stands on this domain; else on the declared one, else on the only one that has what the law needs.
    fn on(self, domain: &str) -> Configured<Self> {
        self.configured().on(domain)
    }
    /// Has this name of its own, where one law is listed twice on one domain.
    fn label(self, label: &str) -> Configured<Self> {
        self.configured().label(label)
    }
    /// Is evaluated on every n-th step; its last shares are held between.
    fn every(self, steps: u32) -> Configured<Self> {
        self.configured().every(steps)
    }
    /// Runs there; else where its size says.
    fn backend(self, backend: Backend) -> Configured<Self> {
        self.configured().backend(backend)
    }
    /// Sums far rows together, with this relative error; see [`Configured::far_field`].
    fn far_field(self, error: f64) -> Configured<Self> {
        self.configured().far_field(error)
    }
    /// Is switched off at first.
    fn off(self) -> Configured<Self> {
        self.configured().off()
    }
    /// Must run: dormancy is a fault.
    fn required(self) -> Configured<Self> {
        self.configured().required()
    }
}

impl<L: Compile> Configure for L {}

/// An engine that is being put together. Nothing is checked before [`Builder::build`], which finds all faults at once.
pub struct Builder<P: Scalar> {
    domains: Vec<Domain<P>>,
    constants: Domain<P>,
    fields: Vec<(PropertyInfo, Arc<dyn Field<P>>)>,
    laws: Vec<Listed<P>>,
    chains: Vec<crate::pipeline::FusedChain<P>>,
    integrator: Box<dyn Integrator>,
    step: Option<f64>,
    observe: Vec<(String, String)>,
    required: Vec<String>,
    settings: Settings,
    moving_origin: Option<PropertyInfo>,
    backend: Backend,
    threads: Option<usize>,
    isa: Option<Isa>,
    estimates: bool,
}

impl<P: Scalar> core::fmt::Debug for Builder<P> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let laws: Vec<_> = self.laws.iter().map(|law| law.entry.label()).collect();
        f.debug_struct("Builder").field("domains", &self.domains).field("laws", &laws).finish_non_exhaustive()
    }
}

impl<P: Scalar> Default for Builder<P> {
    fn default() -> Self {
        Builder {
            domains: Vec::new(),
            constants: Domain::new(SCENE),
            fields: Vec::new(),
            laws: Vec::new(),
            chains: Vec::new(),
            integrator: Box::new(Leapfrog::default()),
            step: None,
            observe: Vec::new(),
            required: Vec::new(),
            settings: Settings::default(),
            moving_origin: None,
            backend: Backend::Auto,
            threads: None,
            isa: None,
            estimates: true,
        }
    }
}

impl<P: Scalar> Builder<P> {
    /// Adds a domain.
    #[must_use]
    pub fn domain(mut self, domain: Domain<P>) -> Self {
        self.domains.push(domain);
        self
    }

    /// Adds a constant of the scene: a number, or the components of a vector, `[0.0, 0.0, -9.81]`.
    #[must_use]
    pub fn constant(mut self, property: impl AsProperty, value: impl Into<Values>) -> Self {
        let info = property.info();
        self.constants = self.constants.with(info, value.into().as_one(info.kind.width()));
        self
    }

    /// Adds a field: a closure `|position, time| vector`, or one of [`crate::field`].
    #[must_use]
    pub fn field(mut self, property: impl AsProperty, field: impl Field<P>) -> Self {
        self.fields.push((property.info(), Arc::new(field)));
        self
    }

    /// Adds a law.
    #[must_use]
    pub fn law(mut self, law: impl Listing) -> Self {
        let options = law.options();
        self.push(law.compiled(), options);
        self
    }

    /// Adds laws composed at compile time.
    #[must_use]
    pub fn laws<T: Chained>(mut self, chain: Chain<T>) -> Self {
        let first = self.laws.len();
        for compiled in chain.compiled() {
            self.push(compiled, Options::default());
        }
        self.chains.extend(chain.fused((first..self.laws.len()).collect()));
        self
    }

    /// Adds a law whose loops are made already.
    #[must_use]
    pub fn listed(mut self, compiled: Compiled<P>, options: Options) -> Self {
        self.push(compiled, options);
        self
    }

    fn push(&mut self, compiled: Compiled<P>, options: Options) {
        let entry = Entry { signature: *compiled.signature(), shape: compiled.shape(), options, failed: None };
        self.laws.push(Listed { entry, compiled });
    }

    /// The integrator; leapfrog where none is given.
    #[must_use]
    pub fn integrator(mut self, integrator: impl Integrator + 'static) -> Self {
        self.integrator = Box::new(integrator);
        self
    }

    /// The same, chosen at run time.
    #[must_use]
    pub fn boxed_integrator(mut self, integrator: Box<dyn Integrator>) -> Self {
        self.integrator = integrator;
        self
    }

    /// The fixed step, in s. Without one every frame is one step. An adaptive integrator takes it as its first try, and
    /// ends a step of its own with every frame.
    #[must_use]
    pub fn step(mut self, seconds: f64) -> Self {
        self.step = Some(seconds);
        self
    }

    /// Keeps the rounding error of every addition to the state, and adds it back (Kahan's sum): for long runs of small
    /// steps, and for f32. Costs a vector as long as the state, and loops of their own for kicks and drifts.
    #[must_use]
    pub fn compensated(mut self) -> Self {
        self.settings.compensated = true;
        self
    }

    /// Lets steps go across jumps of laws and fields, which are otherwise looked for: a step is cut where a switch turns, or
    /// a row leaves a region. For scenes of many rows that touch all the time, where errors of first order at each touch are
    /// no matter, and cut steps would be.
    #[must_use]
    pub fn across_jumps(mut self) -> Self {
        self.settings.across_jumps = true;
        self
    }

    /// Measures rows of a coordinate from an origin that moves with them: digits then go to what rows are apart, and not to how
    /// far from where coordinates begin all of them are. For f32, and for small scenes far out. The origin is amid the rows
    /// from the beginning on, and is moved there at the end of a frame where they have gone from it by some of their extents;
    /// integrators begin anew then. Rows at one place have no extent, and the origin stays for them. What is given in a
    /// [`Domain`], and [`State::numbers`], are from where coordinates begin; what else is read of the state, or written to it, is
    /// from [`State::origin`], and so is the magnitude that a relative tolerance is a part of. Laws of pairs and links have to
    /// look at differences only, which is checked by their derivatives; laws of single rows and fields must not look at the
    /// coordinate at all.
    #[must_use]
    pub fn moving_origin(mut self, coordinate: impl AsProperty) -> Self {
        self.moving_origin = Some(coordinate.info());
        self
    }

    /// Looks at a property: what it needs is computed and kept. States need not be observed.
    #[must_use]
    pub fn observe(mut self, domain: &str, property: impl AsProperty) -> Self {
        self.observe.push((domain.to_owned(), property.info().name.to_owned()));
        self
    }

    /// Makes dormancy a fault, for every law.
    #[must_use]
    pub fn strict(mut self) -> Self {
        self.settings.strict = true;
        self
    }

    /// Makes dormancy of the law of this label, or else this name, a fault.
    #[must_use]
    pub fn require(mut self, name: &str) -> Self {
        self.required.push(name.to_owned());
        self
    }

    /// Where laws run that do not say.
    #[must_use]
    pub fn backend(mut self, backend: Backend) -> Self {
        self.backend = backend;
        self
    }

    /// Threads for parallel laws; all cores where none is given.
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = Some(threads);
        self
    }

    /// The instruction set of the loops; the widest that the processor has where none is given. Results do not depend
    /// on it, but for laws that allow estimates.
    #[must_use]
    pub fn isa(mut self, isa: Isa) -> Self {
        self.isa = Some(isa);
        self
    }

    /// Whether laws that allow `estimates` are computed with them, where there are many pairs; they are if this is not called.
    /// Without, every result has the same bits on every processor, but for far fields; with, on every processor of one family, on any
    /// number of threads.
    #[must_use]
    pub fn estimates(mut self, estimates: bool) -> Self {
        self.estimates = estimates;
        self
    }

    /// Checks everything, orders the laws, and makes the engine.
    ///
    /// # Errors
    /// All that is wrong with the data and the settings; if the data are right, all that is wrong with the laws too.
    pub fn build(self) -> Result<Engine<P>, Faults> {
        compiled_here!(<P> |builder: Builder<P>| -> Result<Engine<P>, Faults> { builder.checked() })(self)
    }

    fn checked(mut self) -> Result<Engine<P>, Faults> {
        let mut faults = Vec::new();
        if let Some(step) = self.step.filter(|step| !(*step > 0.0 && step.is_finite())) {
            faults.push(Fault::Step { what: "the step".to_owned(), value: step, allowed: "a finite time above 0" });
        }
        for law in &mut self.laws {
            if law.entry.options.backend == Backend::Auto {
                law.entry.options.backend = self.backend;
            }
            if law.entry.options.backend == Backend::Parallel && cfg!(not(feature = "parallel")) {
                faults.push(Fault::NoParallel);
            }
            if law.entry.options.backend == Backend::Gpu && cfg!(not(feature = "gpu")) {
                faults.push(Fault::NoGpu);
            }
        }
        faults.dedup();
        faults.extend(self.laws.iter().flat_map(parameter_faults));
        faults.extend(self.laws.iter().filter_map(super::foreign::not_made));
        for name in &self.required {
            let missing = no_law(name, &self.laws);
            let laws = self.laws.iter_mut().filter(|law| law.entry.label() == name);
            if laws.map(|law| law.entry.options.required = true).count() == 0 {
                faults.push(missing);
            }
        }
        let machine = Machine { estimates: self.estimates, ..machine(self.threads, self.isa, &mut faults) };
        let mut machine = Machine { device: super::device::device(&self.laws), ..machine };
        let origin = self.moving_origin.map(|property| Origin::amid(property, &mut self.domains)).transpose();
        let origin = origin.unwrap_or_else(|fault| {
            faults.push(fault);
            None
        });
        let mut state = match State::new(self.domains.into_iter().chain([self.constants]), self.fields) {
            Ok(state) => state,
            Err(more) => return Err(more.after(faults)),
        };
        state.origin = origin;
        let mut integrator = self.integrator;
        let (laws, chains, observe) = (&self.laws, &self.chains, &self.observe);
        let mut composed = |integrator: &dyn Integrator| {
            Pipeline::new(laws, chains, &mut state, integrator, observe, self.settings, &machine)
        };
        let mut pipeline = composed(&*integrator);
        if pipeline.as_ref().is_ok_and(|pipeline| integrator.suit(&pipeline.structure)) {
            pipeline = composed(&*integrator);
        }
        let pipeline = match pipeline {
            Ok(pipeline) => Faults::unless_empty(faults, pipeline)?,
            Err(more) => return Err(more.after(faults)),
        };
        let (pipeline, calibration) = super::device::calibrated(
            pipeline,
            (&mut self.laws, &self.chains, &mut machine),
            (&mut state, &mut *integrator),
            (&self.observe, self.settings, self.step),
        )?;
        log_changes(&Report::default(), &pipeline.registry.report);
        let time = state.time().to_f64();
        if let Some(step) = self.step {
            integrator.set_first_step(step);
        }
        let fixed = self.step.filter(|_| !integrator.is_adaptive());
        let step = fixed.map(|step| FixedStep { step, per_second: 1.0 / step });
        let mut engine = Engine {
            state,
            laws: self.laws,
            chains: self.chains,
            integrator,
            pipeline,
            machine,
            observe: self.observe,
            settings: self.settings,
            step,
            remainder: 0.0,
            steps: 0,
            evaluations: 0,
            derivatives: 0,
            tried: [0; 2],
            clock: Clock { time, since: 0, step: 0.0 },
            touched: false,
            stale: false,
            calibration,
            quiet: f64::NAN,
            lent_changes: Some(0),
            kept: None,
        };
        engine.let_origin_move()?;
        engine.foresee();
        engine.observe()?;
        Ok(engine)
    }
}

/// A fault for each parameter of a law that is infinite or NaN.
fn parameter_faults<P: Scalar>(law: &Listed<P>) -> Vec<Fault> {
    let declared = law.entry.signature.parameters.iter();
    let names = declared.flat_map(|parameter| core::iter::repeat_n(parameter.name, parameter.width));
    let bad = names.zip(&law.compiled.parameters).filter(|(_, value)| !value.is_finite());
    let fault = |(parameter, value): (&str, &f64)| Fault::ParameterNotFinite {
        law: law.entry.label().to_owned(),
        parameter: parameter.to_owned(),
        value: *value,
    };
    bad.map(fault).collect()
}

/// A fault for a name that no listed law has.
pub(super) fn no_law<P: Scalar>(name: &str, laws: &[Listed<P>]) -> Fault {
    let labels = laws.iter().map(|law| law.entry.label());
    Fault::NoLaw { law: name.to_owned(), nearest: nearest(name, labels) }
}

/// Logs, once, every law that falls asleep, and every one that wakes.
pub(super) fn log_changes(before: &Report, after: &Report) {
    for law in &after.laws {
        let old = before.laws.iter().find(|old| old.label == law.label && old.domain == law.domain);
        match (&law.status, old.map(|old| &old.status)) {
            (Status::Dormant(_), Some(Status::Dormant(_))) => {}
            (Status::Dormant(_), _) => log::warn!("{law}"),
            (Status::Active { .. }, Some(Status::Dormant(_))) => log::info!("{law}"),
            _ => {}
        }
    }
    for unused in after.unused.iter().filter(|unused| !before.unused.contains(unused)) {
        log::info!("{unused} is unused: no running law touches it");
    }
}
