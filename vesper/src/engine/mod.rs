//! Client time: frames cut into steps, and everything a client may do between them.
//!
//! In: a builder's domains, fields, laws, integrator, observers. Out: [`Engine`], which advances a state by frames.
//! Never: a law of physics, a file; a clock, but while it is built, for laws that are to run where that is fastest.

mod blow_up;
mod build;
mod checkpoint;
#[cfg_attr(not(feature = "gpu"), path = "without_device.rs")]
mod device;
mod energy;
mod foreign;
mod late;
mod lent;
mod machine;
mod observe;
mod origin;
mod stable;

pub use build::{Builder, Configure, Configured, Listing};
pub use checkpoint::{Checkpoint, ColumnData, DomainData, LawData};
pub use late::Late;

use crate::column::Storage;
use crate::error::{Fault, Faults};
use crate::integrate::{Integrator, System, split};
use crate::pipeline::{FusedChain, Key, Listed, Machine, Pipeline, Probe, Runner, Settings, lent_columns};
use crate::real::{Scalar, compiled_here};
use crate::registry::{Backend, Report};
use crate::state::State;
use lent::with_runner;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A state, the laws that drive it, and the method that integrates them.
pub struct Engine<P: Scalar> {
    state: State<P>,
    laws: Vec<Listed<P>>,
    chains: Vec<FusedChain<P>>,
    integrator: Box<dyn Integrator>,
    pipeline: Pipeline<P>,
    machine: Machine,
    observe: Vec<(String, String)>,
    settings: Settings,
    /// The fixed step, in s; `None` takes every frame as one step.
    step: Option<FixedStep>,
    /// The part of past frames that no step has covered, in s.
    remainder: f64,
    steps: u64,
    evaluations: u64,
    derivatives: u64,
    /// Steps that an adaptive integrator gave up, and those that it kept.
    tried: [u64; 2],
    /// Time at step `since`, from which steps are counted, so that the time does not gather rounding errors.
    clock: Clock,
    /// The client may have changed values since the last step.
    touched: bool,
    /// A law was switched.
    stale: bool,
    /// What was found where steps were timed here and there.
    calibration: Vec<String>,
    /// The length of a frame that is one step in which nothing moves, and after which nothing remains; NaN where that is
    /// not known.
    quiet: f64,
    /// How often the client asked to change what it lends, as of the last step; `None` if nobody can know.
    lent_changes: Option<u64>,
    /// The state as it was, where blow-ups are traced.
    kept: Option<blow_up::Kept<P>>,
}

/// A fixed step, in s, and how many there are in a second: a product in every frame instead of a division.
#[derive(Clone, Copy, Debug)]
struct FixedStep {
    step: f64,
    per_second: f64,
}

#[derive(Clone, Copy, Debug)]
struct Clock {
    time: f64,
    since: u64,
    step: f64,
}

impl Clock {
    fn at(&self, steps: u64) -> f64 {
        // Signed: one instruction instead of six, and no count of steps is ever that long.
        self.time + self.step * (steps - self.since).cast_signed() as f64
    }
}

impl<P: Scalar> core::fmt::Debug for Engine<P> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Engine")
            .field("precision", &P::NAME)
            .field("integrator", &self.integrator.name())
            .field("time", &self.time())
            .field("steps", &self.steps)
            .field("laws", &self.report().laws)
            .finish_non_exhaustive()
    }
}

impl<P: Scalar> Engine<P> {
    /// Begins an engine.
    pub fn builder() -> Builder<P> {
        Builder::default()
    }

    /// Advances by one frame of this length, in s: by as many fixed steps as fit, the rest is carried to the next frame;
    /// without a fixed step, by one step of the frame's own length.
    ///
    /// # Errors
    /// The frame is no length of time; the client changed the state so that laws no longer fit it; the client still
    /// borrows lent memory; a number became infinite or NaN.
    #[inline]
    pub fn advance(&mut self, frame: f64) -> Result<(), Faults> {
        // An engine without laws costs its client a comparison and a clock.
        if frame == self.quiet {
            self.pass_time(1);
            return Ok(());
        }
        if !(frame >= 0.0 && frame.is_finite()) {
            return Err(Fault::Step {
                what: "the frame".to_owned(),
                value: frame,
                allowed: "a finite time, 0 or above",
            }
            .into());
        }
        let (count, step, remainder) = match self.step {
            Some(FixedStep { step, per_second }) => {
                let total = self.remainder + frame;
                // A frame that is a multiple of the step but for rounding is that many steps.
                let count = total * per_second + 1e-9;
                if count >= MOST_STEPS {
                    return Err(Fault::TooManySteps { frame, step }.into());
                }
                let count = count as u64;
                (count, step, total - count as f64 * step)
            }
            None if frame == 0.0 => return self.refresh().map(|_| ()),
            None => (1, frame, 0.0),
        };
        let done = self.run(count, step);
        // A law that failed takes no step back.
        if done.as_ref().err().is_none_or(foreign::only_failures) {
            self.remainder = remainder;
        }
        done?;
        self.quiet = if self.pipeline.is_idle() && remainder == 0.0 { step } else { f64::NAN };
        Ok(())
    }

    /// Takes steps in which nothing moves.
    #[inline(always)]
    fn pass_time(&mut self, count: u64) {
        self.steps = self.steps.saturating_add(count).min(i64::MAX.cast_unsigned());
        self.state.set_time(P::from_f64(self.time()));
    }

    /// Takes this many steps of `step` s, whatever the fixed step is, which holds again in the next
    /// [`Engine::advance`]. What is carried from frame to frame stays carried.
    ///
    /// # Errors
    /// As [`Engine::advance`].
    pub fn steps_of(&mut self, count: u64, step: f64) -> Result<(), Faults> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(
                Fault::Step { what: "the step".to_owned(), value: step, allowed: "a finite time above 0" }.into()
            );
        }
        self.run(count, step)
    }

    fn run(&mut self, count: u64, step: f64) -> Result<(), Faults> {
        compiled_here!(<P> |engine: &mut Engine<P>, count: u64, step: f64| -> Result<(), Faults> {
            engine.prepare_and_take(count, step)
        })(self, count, step)
    }

    fn prepare_and_take(&mut self, count: u64, step: f64) -> Result<(), Faults> {
        let done = self.prepared_and_taken(count, step);
        self.with_failures(done)
    }

    fn prepared_and_taken(&mut self, count: u64, step: f64) -> Result<(), Faults> {
        self.prepare()?;
        if self.kept.is_none() {
            return self.take(count, step);
        }
        self.keep()?;
        let first = self.steps;
        self.take(count, step).map_err(|faults| self.trace(faults, first, step))
    }

    fn take(&mut self, count: u64, step: f64) -> Result<(), Faults> {
        if self.clock.step != step {
            self.clock = Clock { time: self.time(), since: self.steps, step };
            self.quiet = f64::NAN;
        }
        if self.pipeline.is_idle() {
            self.pass_time(count);
            return Ok(());
        }
        let (clock, first) = (self.clock, self.steps);
        let integrator = &mut self.integrator;
        let (steps, time, asked, tried, done) = with_runner(
            &mut self.pipeline,
            &self.state,
            (&self.laws, &self.chains, &self.machine),
            (clock.at(first), first),
            |runner| {
                let mut done = Ok(());
                let splits = runner.pipeline.switches.any() && !integrator.is_adaptive();
                for taken in 0..count {
                    runner.ahead = count - taken;
                    done = match splits {
                        true => split(&mut **integrator, runner, step, Runner::again),
                        false => integrator.step(runner, step),
                    };
                    if done.is_err() {
                        break;
                    }
                    runner.step += 1;
                    runner.set_time(clock.at(runner.step));
                    if runner.pipeline.amends {
                        done = integrator.finish(runner);
                        if done.is_err() {
                            break;
                        }
                        runner.run(Key::Amend);
                        // The state moved after the rates that the integrator remembers.
                        integrator.restart();
                        runner.pipeline.vectors.forget_errors();
                        runner.pipeline.switches.holds = false;
                    }
                }
                done = done.and_then(|()| integrator.finish(runner));
                if runner.pipeline.observes {
                    runner.run(Key::Observe);
                }
                let asked = [runner.evaluations, runner.derivatives];
                (runner.step, runner.time, asked, runner.tried, done)
            },
        )?;
        self.steps = steps;
        self.evaluations += asked[0];
        self.derivatives += asked[1];
        self.tried = [self.tried[0] + tried[0], self.tried[1] + tried[1]];
        if let Err(fault) = done {
            // It may have come some way.
            self.clock = Clock { time, since: steps, step };
            return Err(fault.into());
        }
        if self.kept.is_some() {
            // Who traces numbers that become none looks at all of them.
            self.pipeline.come_home(false);
        }
        blow_up::check(&self.pipeline, &self.state, self.machine.isa, (self.steps, self.time()))?;
        if self.state.recentre() {
            // Rounding errors stay with the places that they are of; what else an integrator keeps may be places.
            self.integrator.restart();
            self.pipeline.switches.holds = false;
        }
        Ok(())
    }

    /// Whether columns are where the next step finds them: since the last one neither rows, laws nor what is observed changed, and
    /// no law failed. What changed moves columns when the engine follows, in [`Engine::refresh`] or the next step.
    pub fn is_settled(&self) -> bool {
        !self.stale && self.pipeline.layout == self.state.layout()
    }

    /// Follows what the client changed since the last step.
    #[inline]
    fn prepare(&mut self) -> Result<(), Faults> {
        self.look_after_device()?;
        if !self.is_settled() {
            self.pipeline.come_home(true);
            self.pipeline.tell_loss()?;
            self.rebuild()?;
        }
        if self.touched {
            if self.state.time() != P::from_f64(self.time()) {
                // The client set the clock.
                self.clock = Clock { time: self.state.time().to_f64(), since: self.steps, ..self.clock };
            }
            self.restart();
            self.touched = false;
        }
        if self.pipeline.lends && self.lent_memory_changed() {
            self.restart();
        }
        Ok(())
    }

    /// The state was changed by another hand than the integrator's.
    fn restart(&mut self) {
        self.integrator.restart();
        self.pipeline.vectors.forget_errors();
        self.pipeline.switches.holds = false;
    }

    /// Whether the client may have changed what it lends since this was last asked.
    fn lent_memory_changed(&mut self) -> bool {
        let changes = lent_columns(&self.state).map(|(domain, column)| {
            match &self.state.domains[domain].columns[column].storage {
                Storage::Lent(memory) => memory.changes(),
                Storage::Split(_) | Storage::Link { .. } => Some(0),
            }
        });
        // Memory that somebody else owns can change at any time.
        let before = core::mem::replace(&mut self.lent_changes, changes.sum());
        self.lent_changes.is_none() || self.lent_changes != before
    }

    /// Brings the computed columns that the client looks at up to date.
    fn observe(&mut self) -> Result<(), Faults> {
        if !self.pipeline.observes {
            return Ok(());
        }
        let (time, step) = (self.time(), self.steps);
        let shared = (self.laws.as_slice(), self.chains.as_slice(), &self.machine);
        with_runner(&mut self.pipeline, &self.state, shared, (time, step), |runner| runner.run(Key::Observe))?;
        Ok(())
    }

    fn rebuild(&mut self) -> Result<(), Faults> {
        self.pipeline.come_home(true);
        let before = core::mem::take(&mut self.pipeline.registry.report);
        let rebuilt = Pipeline::new(
            &self.laws,
            &self.chains,
            &mut self.state,
            &*self.integrator,
            &self.observe,
            self.settings,
            &self.machine,
        );
        match rebuilt {
            Ok(pipeline) => {
                // A law that woke, or a field that was set, may see what the others do not.
                self.stale = true;
                let old = core::mem::replace(&mut self.pipeline, pipeline);
                if let Err(faults) = self.let_origin_move() {
                    self.pipeline = old;
                    self.pipeline.registry.report = before;
                    return Err(faults);
                }
            }
            Err(faults) => {
                self.pipeline.registry.report = before;
                return Err(faults);
            }
        }
        build::log_changes(&before, &self.pipeline.registry.report);
        self.foresee();
        self.integrator.restart();
        self.stale = false;
        Ok(())
    }

    /// The time, in s.
    pub fn time(&self) -> f64 {
        self.clock.at(self.steps)
    }

    /// Steps taken; counting ends at 2^63 - 1.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// How often the laws were evaluated.
    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// How often the derivative of all rates along a direction was asked for: for an implicit integrator, as often as its linear
    /// solver took an iteration, and once or more for each step.
    pub fn derivatives(&self) -> u64 {
        self.derivatives
    }

    /// Steps that an adaptive integrator gave up, and those that it kept; both 0 for others.
    pub fn tried_steps(&self) -> [u64; 2] {
        self.tried
    }

    /// The integrator.
    pub fn integrator(&self) -> &dyn Integrator {
        &*self.integrator
    }

    /// The data, to look at.
    pub fn state(&self) -> &State<P> {
        &self.state
    }

    /// The data, to change: values, rows, columns, constants, fields, the time. Laws follow at the next step.
    pub fn state_mut(&mut self) -> &mut State<P> {
        self.touched = true;
        self.quiet = f64::NAN;
        &mut self.state
    }

    /// Who runs, who does not, and why; as of the last step, or of the building.
    pub fn report(&self) -> &Report {
        &self.pipeline.registry.report
    }

    /// Brings report, graph and observed columns up to date with what the client changed, without taking a step.
    ///
    /// # Errors
    /// Laws no longer fit the state, or the client borrows lent memory.
    pub fn refresh(&mut self) -> Result<&Report, Faults> {
        compiled_here!(<P> |engine: &mut Engine<P>| -> Result<(), Faults> {
            engine.refreshed()
        })(self)?;
        Ok(self.report())
    }

    fn refreshed(&mut self) -> Result<(), Faults> {
        let done = self.prepare().and_then(|()| self.observe());
        self.with_failures(done)
    }

    /// Switches a law on or off, by its label, or else its name. The kernels and all data stay.
    ///
    /// # Errors
    /// No law has this label, or it failed.
    pub fn enable(&mut self, law: &str, enabled: bool) -> Result<(), Fault> {
        let missing = build::no_law(law, &self.laws);
        let mut found = false;
        for listed in self.laws.iter_mut().filter(|listed| listed.entry.label() == law) {
            if let Some(fault) = foreign::failed(listed).filter(|_| enabled) {
                return Err(fault);
            }
            self.stale |= listed.entry.options.enabled != enabled;
            listed.entry.options.enabled = enabled;
            self.quiet = f64::NAN;
            found = true;
        }
        if found { Ok(()) } else { Err(missing) }
    }

    /// Lets another thread stop an adaptive integrator inside a frame: once the flag is true, [`Engine::advance`] comes
    /// back with a fault, and the state is that of the last step that was accepted.
    pub fn stop_on(&mut self, flag: Option<Arc<AtomicBool>>) {
        self.machine.stop = flag;
    }

    /// Watches how long laws take.
    pub fn set_probe(&mut self, probe: Option<Arc<dyn Probe>>) {
        self.machine.probe = probe;
    }

    /// Traces numbers that become infinite or NaN to the step and to the first law that gave one, and leaves the state
    /// as it was before that step. Costs a copy of the state per call of [`Engine::advance`].
    pub fn trace_blow_ups(&mut self, on: bool) {
        self.kept = on.then(blow_up::Kept::default);
    }

    /// Where each law of the list runs, in the order of the list; `None` where it does not run.
    pub fn backends(&self) -> Vec<Option<Backend>> {
        let backend = |law| match self.pipeline.threads(law) {
            0 => None,
            _ if self.pipeline.is_on_device(law) => Some(Backend::Gpu),
            1 => Some(Backend::Cpu),
            _ => Some(Backend::Parallel),
        };
        (0..self.laws.len()).map(backend).collect()
    }

    /// What the graph looks like, for people.
    pub fn explain(&self) -> String {
        let text = compiled_here!(<P> |engine: &Engine<P>| -> String {
            engine.pipeline.explain(&engine.state, &*engine.integrator)
        })(self);
        self.calibration.iter().fold(text, |text, line| text + line + "\n")
    }

    /// The graph in the language of Graphviz.
    pub fn to_dot(&self) -> String {
        compiled_here!(<P> |engine: &Engine<P>| -> String { engine.pipeline.to_dot(&engine.state) })(self)
    }
}

/// Steps of a frame that are counted: more would not end in years, and their number would not be exact.
const MOST_STEPS: f64 = 1e15;
