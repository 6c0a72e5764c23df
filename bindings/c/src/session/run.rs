//! An engine of one precision, asked by names.

use super::lending::LentColumn;
use super::{NumberType, Trouble, View, names};
use vesper::prelude::*;
use vesper_cli::assemble::integrators::is_adaptive;
use vesper_cli::assemble::properties;
use vesper_cli::output::checkpoint;
use vesper_cli::scene::Scene;

/// Something that an engine can say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Words {
    /// Which laws run, which do not, and why; what nobody uses.
    Report,
    /// The order of the laws, merged passes, and what moves where.
    Explain,
    /// The same graph in the language of Graphviz.
    Dot,
    /// The complete state, to go on from.
    Checkpoint,
}

/// An engine that runs, and the memory that was lent to it.
#[derive(Debug)]
pub struct Run<P: Precision> {
    pub(super) engine: Engine<P>,
    pub(super) lent: Vec<LentColumn<P>>,
    pub(super) settings: Settings,
}

/// What was asked for when an engine was built, which it does not say itself.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Settings {
    /// The step, in s.
    pub(super) step: Option<f64>,
    /// The property that is measured from an origin which moves.
    pub(super) moving: Option<&'static str>,
}

impl Settings {
    /// Takes over what a scene sets, as [`assemble::extended`](vesper_cli::assemble::extended) does.
    pub(super) fn and(self, scene: &Scene) -> Self {
        let engine = &scene.engine;
        let adaptive = engine.integrator.as_ref().is_some_and(|choice| is_adaptive(&choice.name.value));
        let step = engine.step.as_ref().or(engine.frame.as_ref().filter(|_| !adaptive));
        let moves = engine.moving_origin.as_ref().is_some_and(|moving| moving.value);
        Settings {
            step: step.map(|step| step.value).or(self.step),
            moving: moves.then_some(Position::NAME).or(self.moving),
        }
    }
}

/// A fault of a step.
#[cold]
fn in_step(faults: Faults) -> Trouble {
    Trouble::Run(faults.to_string())
}

impl<P: Precision> Run<P> {
    pub(super) fn new(engine: Engine<P>, lent: Vec<LentColumn<P>>, settings: Settings) -> Self {
        Run { engine, lent, settings }
    }

    /// The engine itself, for whoever speaks Rust.
    pub fn engine(&self) -> &Engine<P> {
        &self.engine
    }

    #[inline]
    pub(super) fn step(&mut self, count: u64, step: f64) -> Result<(), Trouble> {
        self.engine.steps_of(count, step).map_err(in_step)
    }

    #[inline]
    pub(super) fn advance(&mut self, frame: f64) -> Result<(), Trouble> {
        self.engine.advance(frame).map_err(in_step)
    }

    pub(super) fn refresh(&mut self) -> Result<(), Trouble> {
        Ok(self.engine.refresh().map(|_| ())?)
    }

    pub(super) fn begin_anew(&mut self) {
        _ = self.engine.state_mut();
    }

    pub(super) fn is_settled(&self) -> bool {
        self.engine.is_settled()
    }

    pub(super) fn fixed_step(&self) -> Option<f64> {
        // What is adaptive begins with it, and takes each frame as one step.
        self.settings.step.filter(|_| !self.engine.integrator().is_adaptive())
    }

    pub(super) fn trace_blow_ups(&mut self, on: bool) {
        self.engine.trace_blow_ups(on);
    }

    pub(super) fn time(&self) -> f64 {
        self.engine.time()
    }

    pub(super) fn steps(&self) -> u64 {
        self.engine.steps()
    }

    pub(super) fn number_type() -> NumberType {
        if size_of::<P>() == 4 { NumberType::F32 } else { NumberType::F64 }
    }

    /// Rows of a domain.
    pub(super) fn rows(&self, domain: &str) -> Result<usize, Trouble> {
        Ok(self.engine.state().domain(domain)?.rows())
    }

    pub(super) fn lent(&self, domain: &str, property: &str) -> Option<&LentColumn<P>> {
        self.lent.iter().find(|lent| lent.domain == domain && lent.property == property)
    }

    /// The name of a property whose column is used in place: no unit stands behind it, or its own.
    fn in_place<'a>(&self, domain: &str, property: &'a str) -> Result<&'a str, Trouble> {
        let (name, unit) = names::apart(property)?;
        let info = self.engine.state().column(domain, name)?.property();
        if names::factor(domain, info, unit)? == 1.0 {
            return Ok(name);
        }
        let text = format!("{domain}.{name} is in {} where it is: ask without a unit, or have it copied", info.unit);
        Err(Trouble::fault(text))
    }

    pub(super) fn column(&self, domain: &str, property: &str) -> Result<View, Trouble> {
        let property = self.in_place(domain, property)?;
        let column = self.engine.state().column(domain, property)?;
        let (rows, width) = (column.len(), column.property().kind.width());
        let view = if let Some((_, arity, links)) = column.links() {
            View::interleaved(links.as_ptr().cast_mut(), rows, arity, NumberType::Rows)
        } else if let Some(lent) = self.lent(domain, property) {
            let start = lent.memory.look(<[P]>::as_ptr).cast_mut();
            View::interleaved(start, rows, width, Self::number_type())
        } else {
            let components = column.components().unwrap_or_default();
            View::split(components.iter().map(|c| c.as_ptr().cast_mut()), rows, Self::number_type())
        };
        Ok(view.of_rows(column.subset()))
    }

    pub(super) fn column_to_change(&mut self, domain: &str, property: &str) -> Result<View, Trouble> {
        let look = self.column(domain, property)?;
        let property = self.in_place(domain, property)?;
        if look.numbers == NumberType::Rows {
            let text =
                format!("{domain}.{property} is a link, which is not changed in place: remove rows and add others");
            return Err(Trouble::fault(text));
        }
        let column = self.engine.state_mut().column_mut(domain, property)?;
        let split = column.components_mut().map(|mut components| {
            let starts = components.iter_mut().map(|component| component.as_mut_ptr());
            View::split(starts, look.rows, look.numbers)
        });
        let lent = || {
            let start = self.lent(domain, property)?.memory.change(<[P]>::as_mut_ptr);
            Some(View::interleaved(start, look.rows, look.width, look.numbers))
        };
        Ok(View { subset: look.subset, ..split.or_else(lent).unwrap_or(look) })
    }

    pub(super) fn enable(&mut self, law: &str, enabled: bool) -> Result<(), Trouble> {
        Ok(self.engine.enable(law, enabled)?)
    }

    pub(super) fn observe(&mut self, domain: &str, property: &str) -> Result<(), Trouble> {
        let (name, unit) = names::apart(property)?;
        let info = properties::known(name).map_or_else(|| properties::unknown(name, 1, unit), Ok);
        let info = info.map_err(Trouble::fault)?;
        names::factor(domain, &info, unit)?;
        Ok(self.engine.observe_also(domain, info)?)
    }

    pub(super) fn words(&mut self, words: Words) -> Result<String, Trouble> {
        Ok(match words {
            Words::Report => self.engine.refresh()?.to_string(),
            Words::Explain => {
                self.engine.refresh()?;
                self.engine.explain()
            }
            Words::Dot => {
                self.engine.refresh()?;
                self.engine.to_dot()
            }
            Words::Checkpoint => checkpoint::to_json(&self.engine.checkpoint()?).to_string(),
        })
    }

    pub(super) fn restore(&mut self, text: &str) -> Result<(), Trouble> {
        let checkpoint = checkpoint::from_text(text)
            .map_err(|reason| Trouble::fault(format!("the checkpoint cannot be read: {reason}")))?;
        Ok(self.engine.restore(&checkpoint)?)
    }
}
