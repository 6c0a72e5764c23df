//! Runs programs, and answers integrators.

use super::bind::{BoundPass, Pass};
use super::device::Shared;
use super::pass::run_pass;
use super::plan::Key;
use super::switches::Phase;
use super::{FusedChain, Listed, Machine, Pipeline};
use crate::field::Field;
use crate::integrate::{Again, Combination, Pace, Quantity, Register, Rotation, Structure, System};
use crate::law::Part;
use crate::property::{Property, PropertyInfo, Time};
use crate::real::{Isa, Scalar};
use crate::state::State;
use std::sync::atomic::Ordering;
use std::sync::{Arc, OnceLock};

/// What every pass of a run shares.
pub(crate) struct Context<'a, P: Scalar> {
    pub(crate) laws: &'a [Listed<P>],
    pub(crate) chains: &'a [FusedChain<P>],
    pub(crate) fields: &'a [(PropertyInfo, Arc<dyn Field<P>>)],
    pub(crate) lent: &'a [*mut P],
    pub(crate) isa: Isa,
    pub(crate) machine: &'a Machine,
    /// Where columns are, if some can be on a device.
    pub(crate) residency: Option<Shared<P>>,
    pub(crate) time: P,
    pub(crate) steps: [P; 2],
    /// How many numbers behind their own place rates go.
    pub(crate) rates: usize,
    /// What is done about switches and regions.
    pub(crate) phase: Phase,
    /// Notes the first law with a result that is not finite.
    watch: Option<Arc<Watch>>,
    /// Whether anybody looks at laws one by one: a probe, or a watch.
    looks: bool,
}

/// The first law, of those that ran, with a result that is not finite.
#[derive(Debug, Default)]
pub(crate) struct Watch(OnceLock<usize>);

impl Watch {
    pub(crate) fn law(&self) -> Option<usize> {
        self.0.get().copied()
    }
}

impl<'a, P: Scalar> Context<'a, P> {
    /// For laws on a state with these fields and this lent memory, at this time.
    pub(crate) fn new(
        (laws, chains, machine): (&'a [Listed<P>], &'a [FusedChain<P>], &'a Machine),
        fields: &'a [(PropertyInfo, Arc<dyn Field<P>>)],
        lent: &'a [*mut P],
        time: f64,
    ) -> Self {
        Context {
            laws,
            chains,
            fields,
            lent,
            isa: machine.isa,
            machine,
            residency: None,
            time: P::from_f64(time),
            steps: [P::default(); 2],
            rates: 0,
            phase: Phase::Free,
            watch: None,
            looks: machine.probe.is_some(),
        }
    }

    /// Whether laws need not be told apart while they run.
    #[inline(always)]
    pub(crate) fn is_unwatched(&self) -> bool {
        !self.looks
    }

    /// Whether results are looked at law by law.
    #[cfg(feature = "gpu")]
    pub(crate) fn is_watched(&self) -> bool {
        self.watch.is_some()
    }

    /// Notes the law, if it is the first whose results are not finite. `results` gives start, stride and count of each.
    pub(crate) fn watch<I: Iterator<Item = (*mut P, usize, usize)>>(&self, law: usize, results: impl FnOnce() -> I) {
        let Some(watch) = &self.watch else { return };
        let finite = |(start, stride, count): (*mut P, usize, usize)| {
            // SAFETY: the law has just written these numbers; a part that is not wanted has no place.
            start.is_null() || (0..count).all(|row| unsafe { (*start.add(row * stride)).is_finite() })
        };
        if !results().all(finite) {
            // Another law may have been first; then that one stays.
            let _ = watch.0.set(law);
        }
    }

    /// Runs a law, and tells the probe, where there is one.
    pub(crate) fn timed(&self, law: usize, run: impl FnOnce()) {
        match &self.machine.probe {
            None => run(),
            Some(probe) => {
                let from = probe.now();
                run();
                probe.ran(law, from);
            }
        }
    }
}

/// A pipeline at work on a state.
pub(crate) struct Runner<'a, P: Scalar> {
    pub(crate) pipeline: &'a mut Pipeline<P>,
    pub(super) state: &'a State<P>,
    pub(crate) context: Context<'a, P>,
    /// Where laws read the time.
    clock: Option<*mut P>,
    /// The time in full precision.
    pub(crate) time: f64,
    /// The number of the step, for laws that are not evaluated on every one.
    pub(crate) step: u64,
    /// Steps that are left of the frame, with the one that is taken.
    pub(crate) ahead: u64,
    /// Which laws take part, of those that are not evaluated on every step.
    pace: Pace,
    pub(crate) evaluations: u64,
    /// How often derivatives along a direction were asked for.
    pub(crate) derivatives: u64,
    /// Steps that an adaptive integrator gave up, and those that it kept.
    pub(crate) tried: [u64; 2],
}

impl<'a, P: Scalar> Runner<'a, P> {
    /// A runner on a state that has the pipeline's layout, at this time and step.
    pub(crate) fn new(
        pipeline: &'a mut Pipeline<P>,
        state: &'a State<P>,
        (laws, chains, machine): (&'a [Listed<P>], &'a [FusedChain<P>], &'a Machine),
        lent: &'a [*mut P],
        (time, step): (f64, u64),
    ) -> Self {
        if !lent.is_empty() {
            pipeline.forget_addresses();
        }
        let mut context = Context::new((laws, chains, machine), &state.fields, lent, time);
        context.residency = pipeline.begin();
        let clock = super::bind::locate_column(state, 0, Time::NAME, 0).map(|place| place.base.resolve(lent));
        let mut runner = Runner {
            pipeline,
            state,
            context,
            clock,
            time,
            step,
            ahead: 1,
            pace: Pace::Held,
            evaluations: 0,
            derivatives: 0,
            tried: [0; 2],
        };
        runner.set_time(time);
        runner
    }

    /// Runs what a key asks; the energy, where that is what it asks.
    pub(crate) fn run(&mut self, key: Key) -> f64 {
        let Pipeline { programs, vectors, .. } = &mut *self.pipeline;
        let mut energy = 0.0;
        for pass in &mut programs[key.index()].passes {
            // Most are neither held, nor of a law that is not evaluated on every step.
            if pass.every <= 1 && pass.fills.is_none() || is_due(pass, &mut vectors.filled, (self.pace, self.step)) {
                self.context.bring(&pass.touches);
                energy += run_pass(&mut pass.pass, &self.context);
            }
        }
        energy
    }
}

/// A part of the state, and the step that it advances by.
type Advanced = (Part, f64);

/// What the first of these stages is, alone or with the next one, by which steps its states advance, and the stages after it.
#[inline]
pub(super) fn next_key(stages: &[Advanced]) -> Option<(Key, [f64; 2], &[Advanced])> {
    match stages {
        [] => None,
        [(Part::Momenta, kick), (Part::Coordinates, drift), after @ ..] => {
            Some((Key::KickDrift, [*kick, *drift], after))
        }
        [(part, step), after @ ..] => Some((Key::Advance(*part), [*step, 0.0], after)),
    }
}

/// Whether a pass of a law that is not evaluated on every step runs on this one; its shares are then filled.
#[inline(never)]
pub(super) fn is_due<P: Scalar>(pass: &BoundPass<P>, filled: &mut [bool], (pace, step): (Pace, u64)) -> bool {
    let fill = match pace {
        _ if pass.every <= 1 => true,
        Pace::Held => step.is_multiple_of(pass.every.into()),
        Pace::Fast => return false,
        Pace::With(pace) if pass.every != pace => return false,
        Pace::With(_) => true,
    };
    let Some(held) = pass.fills else { return true };
    let due = fill || !filled[held];
    // Shares that were only emptied are filled by the law's own pass, which comes next.
    filled[held] |= due && !matches!(pass.pass, Pass::Release(_));
    due
}

impl<P: Scalar> Runner<'_, P> {
    /// Has the first law noted whose results are not finite.
    pub(crate) fn set_watch(&mut self, watch: Arc<Watch>) {
        self.context.watch = Some(watch);
        self.context.looks = true;
    }

    /// Keeps the state, with its rounding errors, before a step that may be taken again; or brings it back.
    pub(crate) fn again(&mut self, what: Again) {
        let kept = Register::Work(self.pipeline.vectors.last_work());
        let (to, from) = match what {
            Again::Keep => (kept, Register::State),
            Again::Restore => (Register::State, kept),
        };
        self.copy(to, from, Part::All);
        self.pipeline.vectors.errors_again(what == Again::Restore);
    }

    /// Evaluates the laws for what switches and regions make of it; they are held afterwards.
    fn look(&mut self, phase: Phase) {
        self.context.phase = phase;
        self.evaluate(Part::All);
        self.context.phase = Phase::Held;
        // Switches are looked at and held where rows are.
        self.come_home(true);
    }
}

impl<P: Scalar> System for Runner<'_, P> {
    fn time(&self) -> f64 {
        self.time
    }

    fn set_time(&mut self, time: f64) {
        self.time = time;
        self.context.time = P::from_f64(time);
        if let Some(clock) = self.clock {
            // SAFETY: it points to the one number of the scene's time, in the state that the runner holds.
            unsafe { *clock = self.context.time };
        }
    }

    fn evaluate(&mut self, part: Part) {
        self.evaluations += 1;
        self.run(Key::Evaluate(part));
    }

    fn evaluate_to(&mut self, to: Register, part: Part) {
        let Pipeline { programs, vectors, .. } = &*self.pipeline;
        let there = programs[Key::Evaluate(part).index()].rates == vectors.vector(Register::Rates);
        let there = there && !vectors.states.iter().any(|state| state.on_device);
        if !there || !matches!(to, Register::Work(_)) {
            self.evaluate(part);
            return self.copy(to, Register::Rates, part);
        }
        self.context.rates = vectors.behind_rates(to);
        self.evaluate(part);
        self.context.rates = 0;
    }

    fn advance(&mut self, stages: &[(Part, f64)]) {
        if self.pipeline.vectors.compensated {
            // Rounding errors are kept by sums, not by the laws' loops.
            for (part, step) in stages {
                self.evaluations += u64::from(*part != Part::Coordinates);
                self.run(Key::Evaluate(*part));
                self.axpy(Register::State, *step, Register::Rates, *part);
            }
            return;
        }
        let mut rest = stages;
        while let Some((key, steps, after)) = next_key(rest) {
            self.context.steps = steps.map(P::from_f64);
            // A drift that only follows velocities is no evaluation of forces.
            self.evaluations += u64::from(key != Key::Advance(Part::Coordinates));
            self.run(key);
            rest = after;
        }
    }

    fn linear(&mut self, combination: Combination<'_>) {
        if self.linear_on_device(&combination) {
            return;
        }
        // SAFETY: `Runner` is only made for a state with the layout that the vectors were made for, held exclusively.
        unsafe { self.pipeline.vectors.linear(&combination, self.context.lent, self.context.isa) };
    }

    fn copy(&mut self, to: Register, from: Register, part: Part) {
        if self.copy_on_device((to, from), part) {
            return;
        }
        // SAFETY: as above.
        unsafe { self.pipeline.vectors.copy((to, from), part, self.context.lent, self.context.isa) };
    }

    fn magnitudes(&mut self, of: &[Register], part: Part, each: &mut dyn FnMut(usize, &[f64])) {
        self.come_home(false);
        // SAFETY: as above.
        unsafe { self.pipeline.vectors.magnitudes(of, part, self.context.lent, each) };
    }

    fn structure(&self) -> &Structure {
        &self.pipeline.structure
    }

    fn find(&self, name: &str) -> Option<Quantity> {
        self.quantity(name)
    }

    fn read(&self, quantity: Quantity, from: Register, to: &mut [f64]) {
        self.come_home(false);
        self.read_quantity(quantity, from, to);
    }

    fn write(&mut self, quantity: Quantity, from: &[f64]) {
        self.come_home(true);
        self.write_quantity(quantity, from);
    }

    fn momenta_depend_on_momenta(&self) -> bool {
        self.pipeline.structure.momenta_depend_on_momenta.is_some()
    }

    fn coordinates_depend_on_others(&self) -> bool {
        self.pipeline.structure.coordinates_depend_on.is_some()
    }

    fn coordinates_follow_momenta(&mut self) -> bool {
        if !self.pipeline.structure.second_order || self.pipeline.vectors.momentum_behind.is_none() {
            return false;
        }
        self.run(Key::Evaluate(Part::Coordinates));
        self.come_home(false);
        // SAFETY: as above.
        unsafe { self.pipeline.vectors.rates_are_momenta(self.context.lent) }
    }

    fn evaluate_at_pace(&mut self, pace: Pace) {
        let before = core::mem::replace(&mut self.pace, pace);
        self.evaluate(Part::Momenta);
        self.pace = before;
    }

    fn paces(&self) -> Vec<u32> {
        self.pipeline.paces()
    }

    fn steps_done(&self) -> u64 {
        self.step
    }

    fn steps_ahead(&self) -> u64 {
        self.ahead
    }

    fn evaluate_unturned(&mut self) {
        self.evaluations += 1;
        self.run(Key::Unturned);
    }

    fn turn_momenta(&mut self, time: f64, rotation: Rotation) {
        self.come_home(true);
        self.rotate(time, rotation);
    }

    fn turns_amiss(&mut self) -> Option<String> {
        self.find_amiss()
    }

    fn epsilon(&self) -> f64 {
        P::EPSILON
    }

    fn hold(&mut self) -> bool {
        if !self.pipeline.switches.any() {
            return false;
        }
        self.come_home(true);
        self.context.phase = Phase::Held;
        if !self.pipeline.switches.holds {
            // A switch that turns because another one is held may turn that one: some laws' worth of it, and then it must do.
            for _ in 0..4 {
                self.look(Phase::Hold);
                // SAFETY: as above.
                if !unsafe { self.pipeline.switches.keep() } {
                    break;
                }
            }
            // SAFETY: as above.
            unsafe { self.pipeline.switches.note() };
        }
        // SAFETY: as above.
        unsafe { self.pipeline.switches.begin() };
        true
    }

    fn turned(&mut self) -> bool {
        self.look(Phase::Look);
        // SAFETY: as above.
        unsafe { self.pipeline.switches.turned() }
    }

    fn share(&self, weights: [f64; 2]) -> f64 {
        self.pipeline.switches.share(weights)
    }

    fn turn(&mut self) {
        self.come_home(true);
        // SAFETY: as above.
        unsafe { self.pipeline.switches.turn() };
        self.look(Phase::Look);
        // SAFETY: as above.
        unsafe { self.pipeline.switches.note() };
        // SAFETY: as above.
        unsafe { self.pipeline.switches.begin() };
    }

    fn is_stopped(&self) -> bool {
        self.context.machine.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed))
    }

    fn count_step(&mut self, accepted: bool) {
        self.tried[usize::from(accepted)] += 1;
    }
}
