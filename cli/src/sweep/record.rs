//! What is kept of a run: one JSON object.
//!
//! In: the outcome of a run. Out: a [`Record`], JSON from which the same one is read. Never: a time of a clock among what a
//! table shows; `wall_seconds` stays in the JSON.

use serde_json::{Map, Value, json};

use super::ensemble::Ensemble;
use crate::fault::{SceneFault, number};
use crate::output::json;
use crate::reader::Reader;
use crate::run::{LawOutcome, Outcome};
use crate::scene::Scene;

/// A run, in short.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Its number.
    pub run: usize,
    /// Why it did not come to its end; none where it did.
    pub fault: Option<String>,
    /// Time reached, in s.
    pub time: f64,
    /// Steps taken.
    pub steps: u64,
    /// Evaluations of the laws.
    pub evaluations: u64,
    /// Energy, momentum, angular momentum, as `run --json` has them; null of a run that failed.
    pub invariants: Value,
    /// What was measured, in the order of the ensemble; none of a run that failed, or where there is no such number.
    pub measures: Vec<Option<f64>>,
    /// Time of the integration, in s.
    pub wall_seconds: f64,
}

/// Names of the invariants, and of their drifts in tables.
pub const DRIFTS: [(&str, &str); 3] =
    [("energy", "energy_drift"), ("momentum", "momentum_drift"), ("angular_momentum", "angular_momentum_drift")];

impl Record {
    /// A run that could not begin.
    pub fn refused(ensemble: &Ensemble, run: usize, faults: &[SceneFault]) -> Self {
        Self {
            run,
            fault: Some(texts(faults)),
            time: 0.0,
            steps: 0,
            evaluations: 0,
            invariants: Value::Null,
            measures: vec![None; ensemble.measures.len()],
            wall_seconds: 0.0,
        }
    }

    /// A run that came to its end, or broke on its way. One that went on without a law that failed is of other physics than
    /// its neighbours in the table: it counts as failed.
    pub fn new(ensemble: &Ensemble, run: usize, scene: &Scene, outcome: &Outcome) -> Self {
        let mut faults: Vec<String> = outcome.faults.iter().map(|fault| fault.text.clone()).collect();
        // Where all laws have to run, the failure of one is among the faults already.
        if !scene.is_strict() {
            let failed = outcome.laws.iter().filter(|law| law.status == "failed");
            let told = |law: &LawOutcome| format!("law {} failed: {}", law.name, law.reason.as_deref().unwrap_or("?"));
            faults.splice(0..0, failed.map(told));
        }
        let done = faults.is_empty();
        let measure = |measure: &super::Measure| measure.of(scene, &outcome.domains).filter(|_| done);
        Self {
            run,
            fault: (!done).then(|| faults.join("; ")),
            time: outcome.time,
            steps: outcome.steps,
            evaluations: outcome.evaluations,
            invariants: if done { json::invariants(&outcome.drift) } else { Value::Null },
            measures: ensemble.measures.iter().map(measure).collect(),
            wall_seconds: outcome.wall_seconds,
        }
    }

    /// A run that took longer than its limit, in s. Its text says the limit; how far it came is the clock's.
    pub fn given_up(ensemble: &Ensemble, run: usize, limit: f64, outcome: &Outcome) -> Self {
        Self {
            fault: Some(format!("given up after {} s", number(limit))),
            time: outcome.time,
            steps: outcome.steps,
            evaluations: outcome.evaluations,
            wall_seconds: outcome.wall_seconds,
            ..Self::refused(ensemble, run, &[])
        }
    }

    /// The largest relative change of an invariant on the way, where it is known.
    pub fn drift(&self, invariant: &str) -> Option<f64> {
        self.invariants.get(invariant)?.get("max_relative_drift")?.as_f64()
    }

    /// "done" or "failed".
    pub fn status(&self) -> &'static str {
        if self.fault.is_none() { "done" } else { "failed" }
    }

    /// As JSON.
    pub fn to_json(&self, ensemble: &Ensemble) -> Value {
        let parameter = |(path, text): (&str, &str)| match text.parse() {
            Ok(value @ (Value::Number(_) | Value::Bool(_))) => (path.to_owned(), value),
            _ => (path.to_owned(), json!(text)),
        };
        let parameters: Map<String, Value> = ensemble.parameters(self.run).into_iter().map(parameter).collect();
        let both = ensemble.measures.iter().zip(&self.measures);
        let measures: Map<String, Value> = both.map(|(measure, value)| (measure.text.clone(), json!(value))).collect();
        json!({
            "run": self.run,
            "key": ensemble.key(self.run),
            "parameters": parameters,
            "status": self.status(),
            "error": self.fault,
            "time": self.time,
            "steps": self.steps,
            "evaluations": self.evaluations,
            "invariants": self.invariants,
            "measures": measures,
            "wall_seconds": self.wall_seconds,
        })
    }

    /// Reads the record of `run`.
    ///
    /// # Errors
    /// What is wrong with it: also, that it is of another run.
    pub fn read(value: &Value, ensemble: &Ensemble, run: usize) -> Result<Self, String> {
        let root = Reader::new(value);
        if root.field("key")?.text()? != ensemble.key(run) {
            return Err("it is of another run".to_owned());
        }
        let fault = root.field("error")?;
        let measures = root.field("measures")?;
        let measure = |measure: &super::Measure| Ok(measures.field(&measure.text)?.value.as_f64());
        Ok(Self {
            run,
            fault: if fault.value.is_null() { None } else { Some(fault.text()?) },
            time: root.field("time")?.value.as_f64().unwrap_or(f64::NAN),
            steps: root.field("steps")?.count()?,
            evaluations: root.field("evaluations")?.count()?,
            invariants: root.field("invariants")?.value.clone(),
            measures: ensemble.measures.iter().map(measure).collect::<Result<_, String>>()?,
            wall_seconds: root.field("wall_seconds")?.number()?,
        })
    }
}

fn texts(faults: &[SceneFault]) -> String {
    let texts: Vec<&str> = faults.iter().map(|fault| fault.text.as_str()).collect();
    texts.join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::{Measure, Vary};

    #[test]
    fn reads_back_bit_for_bit_and_only_as_its_own_run() {
        let ensemble = Ensemble {
            title: String::new(),
            varies: vec![Vary::read("a.b=[0.1, word, 18446744073709551615]").unwrap()],
            measures: vec![Measure::read("a.b[0]").unwrap(), Measure::read("a.c[0]").unwrap()],
        };
        let record = Record {
            run: 3,
            fault: None,
            time: 0.1 + 0.2,
            steps: 1 << 53,
            evaluations: 7,
            invariants: json!({ "energy": { "max_relative_drift": 1.0 / 3.0 }, "momentum": {} }),
            measures: vec![Some(1e-300 / 3.0), None],
            wall_seconds: 0.25,
        };
        let value = record.to_json(&ensemble);
        assert_eq!(value["parameters"]["a.b"].to_string(), "18446744073709551615");
        assert_eq!((record.drift("energy"), record.drift("momentum")), (Some(1.0 / 3.0), None));
        let read = |text: &str, run| Record::read(&serde_json::from_str(text).unwrap(), &ensemble, run);
        let text = json::text(&value);
        assert_eq!(read(&text, 3), Ok(record));
        assert_eq!(read(&text, 2), Err("it is of another run".to_owned()));
        assert!(read("{}", 3).is_err());
        let broken = Record { fault: Some("broke".to_owned()), ..Record::refused(&ensemble, 1, &[]) };
        let text = json::text(&broken.to_json(&ensemble));
        assert!(text.contains("\"a.b\": 0.1") && text.contains("\"status\": \"failed\""), "{text}");
        assert_eq!(read(&text, 1), Ok(broken));
    }
}
