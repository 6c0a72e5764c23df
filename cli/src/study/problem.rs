//! What is studied: a case with a known answer, or a scene that may have none.
//!
//! In: a [`Case`] or a [`Scene`]. Out: engines for any method, the times at which states are compared, the numbers that
//! are compared, and how far they are from an answer. Never: a choice that knows a case.

use crate::assemble::law_of;
use vesper::law::Mode;
use vesper::prelude::*;
use vesper_laws::catalog::CatalogPrecision;

use super::case::Case;
use super::setup;
use crate::assemble;
use crate::fault::SceneFault;
use crate::run::course::ADAPTIVE_FRAMES;
use crate::run::snapshot::{shown_columns, snapshot};
use crate::scene::Scene;

/// Moments at which a scene is compared, at most; a case has its own.
const MOMENTS: usize = 20;

/// The numbers of every quantity at one time.
pub type Moment = Vec<Vec<f64>>;

/// What a study is of.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Its name in reports.
    pub id: String,
    /// Time at the start, in s.
    pub start: f64,
    /// Times at which states are compared, in s, ascending.
    pub times: Vec<f64>,
    /// What is compared: "bodies.position", and how many numbers a row has.
    pub quantities: Vec<(String, usize)>,
    /// The states there, where they are known.
    pub answer: Option<Answer>,
    /// The step of the scene, in s, where it says one.
    pub step: Option<f64>,
    /// The frame, in s, by which a run of the scene comes to these times where its integrator chooses its steps; without, it
    /// goes from time to time.
    pub frame: Option<f64>,
    /// What no motion changes; without, all that there is.
    pub conserved: Option<Vec<String>>,
    /// Laws that are switched off, by their labels.
    pub off: Vec<String>,
    source: Source,
}

#[derive(Clone, Debug)]
enum Source {
    Case(Box<Case>),
    Scene(Box<Scene>),
}

/// States that runs are held against.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Who gave it.
    pub by: String,
    /// The state at each time.
    pub moments: Vec<Moment>,
    /// What errors of each quantity are measured by.
    pub scales: Vec<f64>,
    /// How far it may be from the truth, in these scales: 0 for one that was given.
    pub uncertainty: f64,
    /// What the rounding of the input alone may make of each state, in these scales, where it is known.
    pub floors: Vec<Option<f64>>,
}

impl Problem {
    /// A case.
    pub fn of_case(case: Case) -> Self {
        let moments =
            case.samples.iter().map(|sample| vec![sample.position.concat(), sample.velocity.concat()]).collect();
        let floor = |growth: f64| f64::max(1e-12, 10.0 * growth * 0.5 * f64::EPSILON);
        let answer = Answer {
            by: "given".to_owned(),
            moments,
            scales: case.scale.to_vec(),
            uncertainty: 0.0,
            floors: case.samples.iter().map(|sample| sample.growth.map(floor)).collect(),
        };
        Problem {
            id: case.id.clone(),
            start: case.start,
            times: case.samples.iter().map(|sample| sample.time).collect(),
            quantities: ["bodies.position", "bodies.velocity"].map(|name| (name.to_owned(), 3)).to_vec(),
            answer: Some(answer),
            step: None,
            frame: None,
            conserved: case.conserved.clone(),
            off: Vec::new(),
            source: Source::Case(Box::new(case)),
        }
    }

    /// A scene, of which `of` is compared, or else what it shows.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn of_scene(id: &str, scene: Scene, of: &[String]) -> Result<Self, Vec<SceneFault>> {
        let engine = assemble::engine::<f64>(&scene)?;
        let asleep = assemble::asleep(&scene, engine.report());
        if !asleep.is_empty() {
            return Err(asleep);
        }
        let shown = shown_columns(&scene, &engine);
        let mut quantities = Vec::new();
        for domain in snapshot(&engine, &shown) {
            for column in domain.columns.iter().filter(|column| !matches!(column.property.kind, Kind::Link(_))) {
                quantities.push((format!("{}.{}", domain.name, column.property.name), column.width()));
            }
        }
        let known = |name: &String| quantities.iter().any(|(quantity, _)| quantity == name);
        if let Some(unknown) = of.iter().find(|name| !known(name)) {
            let names: Vec<&str> = quantities.iter().map(|(name, _)| name.as_str()).collect();
            let text = format!("--of {unknown}: the scene does not show it; it shows {}", names.join(", "));
            return Err(vec![scene.fault_of_file(text)]);
        }
        if !of.is_empty() {
            quantities.retain(|(name, _)| of.contains(name));
        }
        let start = engine.time();
        let Some(end) = scene.engine.end.as_ref().map(|end| end.value).filter(|end| *end > start) else {
            let help = Some("write `end = ..` into [engine], behind the start, or run with --end S".to_owned());
            return Err(vec![SceneFault {
                help,
                ..scene.fault_of_file("there is nothing to study: the scene has no end")
            }]);
        };
        let shown = scene.engine.frame.as_ref().map_or((end - start) / ADAPTIVE_FRAMES, |frame| frame.value);
        let frame = scene.engine.frame.as_ref().or(scene.engine.step.as_ref());
        let frame = frame.map_or((end - start) / MOMENTS as f64, |frame| frame.value);
        let frames = (((end - start) / frame - 1e-9).ceil() as usize).max(1);
        let count = frames.min(MOMENTS);
        // Ends of frames, or of the scene's steps, evenly spread.
        let time = |number: usize| (start + (number * frames).div_ceil(count) as f64 * frame).min(end);
        Ok(Problem {
            id: id.to_owned(),
            start,
            times: (1..=count).map(time).collect(),
            quantities,
            answer: None,
            step: scene.engine.step.as_ref().map(|step| step.value),
            frame: Some(shown),
            conserved: None,
            off: Vec::new(),
            source: Source::Scene(Box::new(scene)),
        })
    }

    /// The same problem, as somebody has it who does not know the answer.
    #[must_use]
    pub fn without_answer(mut self) -> Self {
        self.answer = None;
        self
    }

    /// The least of what errors are measured by; 0 where there is no answer.
    pub(super) fn least_scale(&self) -> f64 {
        let scales = self.answer.as_ref().map_or(&[][..], |answer| &answer.scales);
        scales.iter().copied().reduce(f64::min).unwrap_or(0.0)
    }

    /// The step, in s, that a run with steps of at most this length takes on the way to the first comparison.
    pub(super) fn whole_step(&self, step: f64) -> f64 {
        let way = self.times.first().map_or(step, |first| first - self.start);
        way / super::measure::whole(way, step)
    }

    /// The same problem with a law switched off.
    #[must_use]
    pub fn without_law(&self, label: &str) -> Self {
        let mut without = self.clone();
        without.off.push(label.to_owned());
        without
    }

    /// Whether the law of this label gives rates, so that nothing would move without it.
    pub(super) fn gives_rates(&self, label: &str) -> bool {
        let law = self.scene().and_then(|scene| scene.laws.iter().find(|law| law.called() == label));
        let law = law.zip(self.scene()).and_then(|(law, scene)| law_of(scene, law.called()));
        law.is_some_and(|law| law.ports.iter().any(|port| port.mode == Mode::Rates))
    }

    /// What a row is called, or its number.
    pub(super) fn row_name(&self, quantity: &str, row: usize) -> String {
        let domain = quantity.split_once('.').and_then(|(domain, _)| self.scene()?.domain(domain));
        let label = domain.and_then(|domain| domain.labels.as_ref()?.get(row).cloned());
        label.unwrap_or_else(|| format!("row {row}"))
    }

    /// The unit of a quantity.
    pub(super) fn unit(&self, quantity: &str) -> String {
        let name = quantity.rsplit('.').next().unwrap_or_default();
        crate::assemble::properties::known(name).map_or(String::new(), |property| property.unit.to_owned())
    }

    /// The scene, where it is one.
    pub fn scene(&self) -> Option<&Scene> {
        match &self.source {
            Source::Case(_) => None,
            Source::Scene(scene) => Some(scene),
        }
    }

    /// The time between the start and the last comparison, in s.
    pub fn length(&self) -> f64 {
        self.times.last().map_or(0.0, |end| end - self.start)
    }

    /// An engine at the start, with what `configure` changes.
    ///
    /// # Errors
    /// In words: the integrator refuses the laws, or they do not fit.
    pub fn engine<P: CatalogPrecision>(
        &self,
        configure: impl FnOnce(Builder<P>) -> Builder<P>,
    ) -> Result<Engine<P>, String> {
        let built = match &self.source {
            Source::Case(case) => configure(setup::builder(case)).build(),
            Source::Scene(scene) => {
                let texts =
                    |faults: Vec<SceneFault>| faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
                configure(assemble::builder::<P>(scene).map_err(texts)?).build()
            }
        };
        let texts = |faults: Faults| faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
        let mut engine = built.map_err(texts)?;
        if !self.off.is_empty() {
            for law in &self.off {
                engine.enable(law, false).map_err(|fault| fault.to_string())?;
            }
            engine.refresh().map_err(texts)?;
        }
        Ok(engine)
    }

    /// The compared numbers of an engine as it is; `None` where it does not have them.
    pub fn moment<P: Precision>(&self, engine: &Engine<P>) -> Option<Moment> {
        if let Source::Case(case) = &self.source {
            return setup::numbers(case, engine);
        }
        let names: Option<Vec<_>> = self.quantities.iter().map(|(name, _)| name.split_once('.')).collect();
        let names: Vec<_> = names?.into_iter().map(|(domain, name)| (domain.to_owned(), name.to_owned())).collect();
        let shown = snapshot(engine, &names);
        let numbers = |(domain, name): &(String, String)| {
            let domain = shown.iter().find(|shown| shown.name == *domain)?;
            Some(domain.columns.iter().find(|column| column.property.name == name)?.numbers.clone())
        };
        names.iter().map(numbers).collect()
    }

    /// The largest distance of a row from where the other has it, each quantity by its scale; infinite where a number is none.
    pub fn distance(&self, one: &Moment, other: &Moment, scales: &[f64]) -> f64 {
        let mut worst = 0.0;
        for ((one, other), ((_, width), scale)) in one.iter().zip(other).zip(self.quantities.iter().zip(scales)) {
            for (one, other) in one.chunks_exact(*width).zip(other.chunks_exact(*width)) {
                let square: f64 = one.iter().zip(other).map(|(one, other)| (one - other) * (one - other)).sum();
                let far = if square == 0.0 { 0.0 } else { square.sqrt() / scale };
                worst = if far.is_finite() { f64::max(worst, far) } else { f64::INFINITY };
            }
        }
        worst
    }

    /// The largest magnitude of a row, for each quantity, over some moments.
    pub fn largest(&self, moments: &[Moment]) -> Vec<f64> {
        let of = |(number, (_, width)): (usize, &(String, usize))| {
            let rows = moments.iter().flat_map(|moment| moment[number].chunks_exact(*width));
            rows.map(|row| row.iter().map(|x| x * x).sum::<f64>().sqrt()).fold(0.0, f64::max)
        };
        self.quantities.iter().enumerate().map(of).collect()
    }

    /// What errors are measured by: the largest magnitude of each quantity. One that is always 0 is measured by the first
    /// other one, by how much of it comes about in the whole time.
    pub fn scales(&self, moments: &[Moment]) -> Vec<f64> {
        let largest = self.largest(moments);
        let first = largest.iter().copied().find(|scale| *scale > 0.0).unwrap_or(1.0);
        largest.into_iter().map(|scale| if scale > 0.0 { scale } else { first / self.length().max(1.0) }).collect()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::Problem;

    /// One of the reference problems.
    pub(in crate::study) fn a_case(id: &str) -> Problem {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/references.json");
        let cases = crate::study::read(&std::fs::read_to_string(file).unwrap()).unwrap();
        Problem::of_case(cases.into_iter().find(|case| case.id == id).unwrap())
    }
}
