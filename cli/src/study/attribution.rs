//! What each law of a scene does to what is observed at its end, and what it costs.
//!
//! In: a scene. Out: for each law, how far the end is from where it is with all of them, and the time that the run saves
//! without it. Never: an estimate: each law is switched off in a run of its own.
//!
//! The runs are made by an integrator that comes to rounding, so that they differ by the law and not by the steps; how far
//! the scene's own integrator and step are off is told beside them. Laws need not add up: two that cancel are each as
//! large as their share, and in a chaotic motion any law ends as large as the motion itself.

use serde_json::{Value, json};
use vesper::prelude::*;

use super::measure::{Method, Patience, answer};
use super::problem::{Answer, Moment, Problem};
use crate::scene::Precision as Numbers;

/// What one law does.
#[derive(Clone, Debug, PartialEq)]
pub struct Share {
    /// The law's label.
    pub law: String,
    /// Laws that cannot run without it.
    pub asleep: Vec<String>,
    /// What changes most, by its scale: "bodies.position", the row, its change in the quantity's unit.
    pub quantity: String,
    /// The row's name, or its number.
    pub row: String,
    /// By how much, in the quantity's SI unit.
    pub change: f64,
    /// The unit.
    pub unit: String,
    /// The same by the quantity's scale: the largest magnitude of a row.
    pub by_scale: f64,
    /// The part of the time of an evaluation that is saved without it.
    pub saves: f64,
}

/// What is known of one law.
#[derive(Clone, Debug, PartialEq)]
pub enum Finding {
    /// It was switched off.
    Share(Share),
    /// It cannot be: its label, and why.
    Stays(String, String),
}

/// What all laws of a scene do.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribution {
    /// The scene.
    pub case: String,
    /// The time from start to end, in s.
    pub length: f64,
    /// Who gave the state with all laws.
    pub by: String,
    /// What that may itself be wrong by, by the scales.
    pub uncertainty: f64,
    /// How far the scene's own integrator and step are from it, by the scales; or why they did not come to the end.
    pub own: Result<f64, String>,
    /// The laws, in the order of the scene.
    pub laws: Vec<Finding>,
}

/// What is to be done about a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The budget does not bear to be without it, or, where there is none, it shows beside the error of the step.
    Needed,
    /// The budget bears to be without it.
    Droppable,
    /// It is less than what the scene's own steps are wrong by.
    BelowStep,
    /// It changes nothing.
    Nothing,
}

/// A change of the size of the motion itself.
const SATURATED: f64 = 0.3;

impl Attribution {
    /// Switches off each law in turn. `begins` hears of each.
    ///
    /// # Errors
    /// In words: there is no state with all laws to compare with.
    pub fn of(
        problem: &Problem,
        makers: &[Method],
        patience: &Patience,
        mut begins: impl FnMut(&str),
    ) -> Result<Self, String> {
        begins("all laws");
        let whole = answer(problem, makers, patience)?;
        let maker = makers.iter().find(|method| whole.by.starts_with(method.integrator.name));
        let method = maker.ok_or("no integrator comes to the end")?;
        let (_, per_evaluation) = method.end(problem, patience)?;
        begins("the scene as it runs");
        let own = as_it_runs(problem, &whole);
        let engine = problem.engine::<f64>(|builder| builder)?;
        let mut laws = Vec::new();
        for law in &engine.report().laws {
            if !matches!(law.status, Status::Active { .. }) {
                continue;
            }
            let label = law.label.clone();
            begins(&label);
            if problem.gives_rates(&label) {
                laws.push(Finding::Stays(label, "it gives the rates: without it nothing moves".to_owned()));
                continue;
            }
            let without = problem.without_law(&label);
            let ended = asleep(&without, &engine).and_then(|asleep| Ok((asleep, method.end(&without, patience)?)));
            laws.push(match ended {
                Err(reason) => Finding::Stays(label, reason),
                Ok((asleep, (end, without))) => Finding::Share(Share {
                    law: label,
                    asleep,
                    saves: 1.0 - without / per_evaluation,
                    ..farthest(problem, &whole, &end)
                }),
            });
        }
        let Answer { by, uncertainty, .. } = whole;
        Ok(Attribution { case: problem.id.clone(), length: problem.length(), by, uncertainty, own, laws })
    }

    /// What is to be done about a law, where an error of `budget` is allowed.
    pub fn verdict(&self, share: &Share, budget: Option<f64>) -> Verdict {
        let sure = share.by_scale + self.uncertainty;
        let step = self.own.as_ref().copied().unwrap_or(0.0).max(self.uncertainty);
        match budget {
            _ if share.by_scale == 0.0 => Verdict::Nothing,
            Some(error) if sure <= error => Verdict::Droppable,
            None if share.by_scale <= step => Verdict::BelowStep,
            _ => Verdict::Needed,
        }
    }

    /// Whether the share of a law is as large as what is observed, so that its size says nothing more.
    pub fn is_saturated(share: &Share) -> bool {
        share.by_scale >= SATURATED
    }

    /// As JSON.
    pub fn to_json(&self, budget: Option<f64>) -> Value {
        let laws = self.laws.iter().map(|law| match law {
            Finding::Stays(law, why) => json!({ "law": law, "verdict": "stays", "why": why }),
            Finding::Share(share) => json!({
                "law": share.law, "asleep_without": share.asleep, "quantity": share.quantity, "row": share.row,
                "change": share.change, "unit": share.unit, "by_scale": share.by_scale, "saves": share.saves,
                "saturated": Self::is_saturated(share),
                "verdict": match self.verdict(share, budget) {
                    Verdict::Needed => "needed",
                    Verdict::Droppable => "droppable",
                    Verdict::BelowStep => "below_step",
                    Verdict::Nothing => "nothing",
                },
            }),
        });
        json!({
            "case": self.case, "time": self.length, "by": self.by, "uncertainty": self.uncertainty,
            "error_of_the_step": self.own.as_ref().ok(), "own_run_broke": self.own.as_ref().err(), "budget": budget,
            "laws": laws.collect::<Vec<_>>(),
        })
    }
}

/// How far a scene's own integrator and step end from the answer.
fn as_it_runs(problem: &Problem, whole: &Answer) -> Result<f64, String> {
    let numbers = problem.scene().and_then(|scene| scene.engine.precision.as_ref()).map(|numbers| numbers.value);
    let end = match numbers.unwrap_or_default() {
        Numbers::F32 => end::<f32>(problem),
        Numbers::F64 => end::<f64>(problem),
        Numbers::DoubleDouble => end::<DoubleDouble>(problem),
    };
    let (end, exact) = end?.zip(whole.moments.last()).ok_or("the state lacks what is compared")?;
    Ok(problem.distance(&end, exact, &whole.scales))
}

/// Where it ends, as it runs in a precision.
fn end<P: Precision>(problem: &Problem) -> Result<Option<Moment>, String> {
    let mut engine = problem.engine::<P>(|builder| builder)?;
    let words = |faults: Faults| faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
    engine.advance(problem.length()).map_err(words)?;
    Ok(problem.moment(&engine))
}

/// Laws that ran with all, and do not run now, besides the one that is switched off.
fn asleep(without: &Problem, with: &Engine<f64>) -> Result<Vec<String>, String> {
    let engine = without.engine::<f64>(|builder| builder)?;
    let runs = |engine: &Engine<f64>, label: &str| {
        engine.report().laws.iter().any(|law| law.label == label && matches!(law.status, Status::Active { .. }))
    };
    let labels = with.report().laws.iter().map(|law| law.label.as_str());
    let fell = labels
        .filter(|label| runs(with, label) && !runs(&engine, label) && !without.off.iter().any(|off| off == label));
    Ok(fell.map(str::to_owned).collect())
}

/// The row that is farthest, by its quantity's scale.
fn farthest(problem: &Problem, whole: &Answer, end: &Moment) -> Share {
    let mut worst = Share {
        law: String::new(),
        asleep: Vec::new(),
        quantity: String::new(),
        row: String::new(),
        change: 0.0,
        unit: String::new(),
        by_scale: 0.0,
        saves: 0.0,
    };
    let Some(exact) = whole.moments.last() else { return worst };
    for (number, (quantity, width)) in problem.quantities.iter().enumerate() {
        let rows = end[number].chunks_exact(*width).zip(exact[number].chunks_exact(*width));
        for (row, (one, other)) in rows.enumerate() {
            let change = one.iter().zip(other).map(|(one, other)| (one - other).powi(2)).sum::<f64>().sqrt();
            let by_scale = change / whole.scales[number];
            if by_scale > worst.by_scale || worst.quantity.is_empty() || by_scale.is_nan() {
                let (row, unit) = (problem.row_name(quantity, row), problem.unit(quantity));
                worst = Share { quantity: quantity.clone(), row, change, unit, by_scale, ..worst };
            }
        }
    }
    worst
}
