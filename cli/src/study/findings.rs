//! What a study has found: its runs, what refused, whose answers were made; as plain data, as JSON and as CSV.
//!
//! In: runs. Out: the best and the cheapest of them, text for files. Never: a run that was not made.

use serde_json::{Map, Value, json};
use vesper::prelude::Backend;

use super::budget::Budget;
use super::grid::{Keeper, Refusal};
use super::measure::{Method, Run, Setting};
use super::problem::Problem;
use crate::assemble::integrators::integrator;
use crate::reader::Reader;
use crate::scene::{PRECISIONS, Precision as Numbers};

/// Errors at which the cheapest run is told.
pub const LEVELS: [f64; 3] = [1e-6, 1e-9, 1e-12];

/// Who gave the answer of a problem, and how far it may be from the truth; or why there is none.
pub type Told = Result<(String, f64), String>;

/// All that a study has found.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// Problems in their order, and their answers.
    pub answers: Vec<(String, Told)>,
    /// Runs, as they were made.
    pub runs: Vec<Run>,
    /// Integrators that cannot.
    pub refusals: Vec<Refusal>,
}

/// Keeps everything, and tells nobody.
impl Keeper for Findings {
    fn ran(&mut self, run: Run) {
        self.runs.push(run);
    }

    fn timed(&mut self, again: Run) {
        self.time(again);
    }

    fn refused(&mut self, refusal: Refusal) {
        self.refusals.push(refusal);
    }
}

impl Findings {
    /// The runs of a problem.
    pub fn of<'s, 'c>(&'s self, case: &'c str) -> impl Iterator<Item = &'s Run> + use<'s, 'c> {
        self.runs.iter().filter(move |run| run.case == case)
    }

    /// Puts a run in the place of the same one with other times.
    pub fn time(&mut self, again: Run) {
        let known = self.runs.iter_mut().find(|run| run.case == again.case && run.method.is(&again.method));
        if let Some(known) = known {
            *known = again;
        }
    }

    /// The run that comes nearest to the answer; of several, the fastest.
    pub fn best(&self, case: &str) -> Option<&Run> {
        let key = |run: &&Run| (run.error.unwrap_or(f64::INFINITY), run.wall[0]);
        self.of(case).filter(|run| run.broke.is_none()).min_by(|one, other| {
            let ((one, fast), (other, slow)) = (key(one), key(other));
            one.total_cmp(&other).then(fast.total_cmp(&slow))
        })
    }

    /// The fastest run whose error is at most this, what the answer may be wrong by counted in.
    pub fn cheapest(&self, case: &str, error: f64) -> Option<&Run> {
        let meets = |run: &&Run| run.broke.is_none() && run.bound.is_some_and(|bound| bound <= error);
        self.of(case).filter(meets).min_by(|one, other| one.wall[0].total_cmp(&other.wall[0]))
    }

    /// The stable runs that no other one beats in both time and error, from fast to exact.
    pub fn front(&self, case: &str) -> Vec<&Run> {
        let mut runs: Vec<&Run> = self.of(case).filter(|run| run.stable && run.error.is_some()).collect();
        runs.sort_by(|one, other| one.wall[0].total_cmp(&other.wall[0]));
        let mut best = f64::INFINITY;
        runs.retain(|run| {
            let gains = run.error.is_some_and(|error| error < best);
            best = run.error.map_or(best, |error| best.min(error));
            gains
        });
        runs
    }

    /// The same object, with the choice for each problem where there is a budget.
    pub fn to_json_and(&self, budget: Option<&Budget>, problems: &[Problem]) -> Value {
        let mut object = self.to_json();
        if let (Some(budget), Some(fields)) = (budget, object.as_object_mut()) {
            let choice =
                |problem: &Problem| (problem.id.clone(), budget.choice(problem, self).map_or(Value::Null, run));
            let choices: Map<String, Value> = problems.iter().map(choice).collect();
            fields.insert("choice".to_owned(), Value::Object(choices));
        }
        object
    }

    /// The object that `study --json` prints and `study.json` holds.
    pub fn to_json(&self) -> Value {
        let mut best = Map::new();
        let mut cheapest = Map::new();
        let mut answers = Map::new();
        for (case, answer) in &self.answers {
            best.insert(case.clone(), self.best(case).map_or(Value::Null, run));
            let at = |level: &f64| (format!("{level:e}"), self.cheapest(case, *level).map_or(Value::Null, run));
            cheapest.insert(case.clone(), Value::Object(LEVELS.iter().map(at).collect()));
            let told = match answer {
                Ok((by, uncertainty)) => json!({ "by": by, "uncertainty": uncertainty }),
                Err(reason) => json!({ "by": null, "reason": reason }),
            };
            answers.insert(case.clone(), told);
        }
        let refused = |refusal: &Refusal| {
            json!({
                "case": refusal.case,
                "integrator": refusal.integrator,
                "longer_steps": refusal.longer_steps,
                "reason": refusal.reason,
            })
        };
        json!({
            "runs": self.runs.iter().map(run).collect::<Vec<_>>(),
            "best": best,
            "cheapest": cheapest,
            "answers": answers,
            "refused": self.refusals.iter().map(refused).collect::<Vec<_>>(),
        })
    }

    /// The runs that `study.json` holds.
    ///
    /// # Errors
    /// What is wrong with the text, and where.
    pub fn runs_from_json(text: &str) -> Result<Vec<Run>, String> {
        let value: Value = serde_json::from_str(text).map_err(|error| format!("it is no JSON: {error}"))?;
        Reader::new(&value).field("runs")?.list(run_from)
    }

    /// The runs, one in a line.
    pub fn to_csv(&self) -> String {
        let mut text =
            "case,integrator,setting,value,precision,compensated,backend,wall_seconds,wall_shortest,wall_longest,\
                        evaluations,steps,rejected,error,bound,by_floor,stable,broke\n"
                .to_owned();
        let number = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:e}"));
        for run in &self.runs {
            let Method { integrator, setting, numbers, compensated, backend } = run.method;
            let (name, value) = match setting {
                Setting::Step(step) => ("step", step),
                Setting::Tolerance(tolerance) => (integrator.options[0], tolerance),
            };
            let [wall, shortest, longest] = run.wall;
            let cells = [
                quoted(&run.case),
                integrator.name.to_owned(),
                name.to_owned(),
                format!("{value:e}"),
                number_type(numbers).to_owned(),
                compensated.to_string(),
                backend_word(backend).to_owned(),
                format!("{wall:e}"),
                format!("{shortest:e}"),
                format!("{longest:e}"),
                run.evaluations.to_string(),
                run.steps.to_string(),
                run.rejected.to_string(),
                number(run.error),
                number(run.bound),
                number(run.by_floor),
                run.stable.to_string(),
                quoted(run.broke.as_deref().unwrap_or("")),
            ];
            text += &cells.join(",");
            text.push('\n');
        }
        text
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// The word of a number type.
pub fn number_type(numbers: Numbers) -> &'static str {
    PRECISIONS.iter().find(|(_, known)| *known == numbers).map_or("f64", |(word, _)| word)
}

/// The word of a backend.
pub fn backend_word(backend: Backend) -> &'static str {
    match backend {
        Backend::Auto => "auto",
        Backend::Cpu => "cpu",
        Backend::Parallel => "parallel",
        Backend::Gpu => "gpu",
        Backend::Fastest => "fastest",
    }
}

/// A number, or null where it is none.
fn finite(value: Option<f64>) -> Value {
    value.filter(|value| value.is_finite()).map_or(Value::Null, |value| json!(value))
}

fn run(run: &Run) -> Value {
    let Method { integrator, setting, numbers, compensated, backend } = run.method;
    let option = integrator.options.first().copied();
    let (step, tolerance) = match setting {
        Setting::Step(step) => (Some(step), None),
        Setting::Tolerance(tolerance) => (None, Some(tolerance)),
    };
    let mut options = Map::new();
    if let (Some(option), Some(tolerance)) = (option, tolerance) {
        options.insert(option.to_owned(), json!(tolerance));
    }
    let drift: Map<String, Value> =
        run.drift.iter().map(|(name, value)| (name.clone(), finite(Some(*value)))).collect();
    json!({
        "case": run.case,
        "integrator": integrator.name,
        "step": step,
        "rtol": tolerance.filter(|_| option == Some("rtol")),
        "options": options,
        "precision": number_type(numbers),
        "compensated": compensated,
        "backend": backend_word(backend),
        "wall_seconds": run.wall[0],
        "wall_spread": [run.wall[1], run.wall[2]],
        "evaluations": run.evaluations,
        "steps": run.steps,
        "rejected": run.rejected,
        "error": finite(run.error),
        "bound": finite(run.bound),
        "by_floor": finite(run.by_floor),
        "drift": drift,
        "stable": run.stable,
        "broke": run.broke,
    })
}

fn run_from(reader: &Reader<'_>) -> Result<Run, String> {
    let name = reader.field("integrator")?;
    let Some(integrator) = integrator(&name.text()?) else { return name.wrong("the name of an integrator") };
    let setting = match reader.optional("step") {
        Some(step) => Setting::Step(step.number()?),
        None => {
            let Some(option) = integrator.options.first() else { return reader.wrong("`step`") };
            Setting::Tolerance(reader.field("options")?.field(option)?.number()?)
        }
    };
    let word = |name: &str, known: &[(&str, usize)], expected: &str| {
        let field = reader.field(name)?;
        let text = field.text()?;
        known.iter().find(|(word, _)| *word == text).map_or_else(|| field.wrong(expected), |(_, number)| Ok(*number))
    };
    let precisions = PRECISIONS.map(|(_, numbers)| numbers);
    let words = [0, 1, 2].map(|number| (PRECISIONS[number].0, number));
    let numbers = precisions[word("precision", &words, "f32, f64 or double-double")?];
    let backends = [Backend::Auto, Backend::Cpu, Backend::Parallel, Backend::Gpu];
    let words = [0, 1, 2, 3].map(|number| (backend_word(backends[number]), number));
    let backend = backends[word("backend", &words, "auto, cpu, parallel or gpu")?];
    let compensated = reader.field("compensated")?.flag()?;
    let broke = reader.optional("broke").map(|broke| broke.text()).transpose()?;
    // Infinite errors are null in a file.
    let number = |name: &str| reader.optional(name).map(|number| number.number()).transpose();
    let error = number("error")?.or(broke.as_ref().map(|_| f64::INFINITY));
    let spread = reader.field("wall_spread")?.list(Reader::number)?;
    let [shortest, longest] = spread[..] else { return reader.field("wall_spread")?.wrong("two times") };
    let drift = reader.field("drift")?;
    let Some(drifts) = drift.value.as_object() else { return drift.wrong("an object") };
    Ok(Run {
        case: reader.field("case")?.text()?,
        method: Method { integrator, setting, numbers, compensated, backend },
        wall: [reader.field("wall_seconds")?.number()?, shortest, longest],
        evaluations: reader.field("evaluations")?.count()?,
        steps: reader.field("steps")?.count()?,
        rejected: reader.field("rejected")?.count()?,
        error,
        bound: number("bound")?.or(broke.as_ref().map(|_| f64::INFINITY)),
        by_floor: number("by_floor")?,
        drift: drifts.iter().map(|(name, value)| (name.clone(), value.as_f64().unwrap_or(f64::NAN))).collect(),
        stable: reader.field("stable")?.flag()?,
        broke,
    })
}

impl Method {
    /// Whether it is the same way to run a problem.
    pub fn is(&self, other: &Method) -> bool {
        let same = match (self.setting, other.setting) {
            (Setting::Step(one), Setting::Step(other)) | (Setting::Tolerance(one), Setting::Tolerance(other)) => {
                (one - other).abs() <= 1e-12 * other
            }
            _ => false,
        };
        same && self.integrator.name == other.integrator.name
            && (self.numbers, self.compensated, self.backend) == (other.numbers, other.compensated, other.backend)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn a_run(wall: f64, error: f64) -> Run {
        let integrator = integrator("dormand_prince_8").unwrap();
        let method = Method {
            integrator,
            setting: Setting::Tolerance(1e-9),
            numbers: Numbers::F64,
            compensated: true,
            backend: Backend::Cpu,
        };
        Run {
            case: "a".to_owned(),
            method,
            wall: [wall, 0.9 * wall, 1.1 * wall],
            evaluations: 120,
            steps: 10,
            rejected: 1,
            error: Some(error),
            bound: Some(2.0 * error),
            by_floor: None,
            drift: vec![("energy".to_owned(), 1e-10)],
            stable: true,
            broke: None,
        }
    }

    #[test]
    fn the_front_is_what_nothing_beats_in_both() {
        let runs = vec![a_run(1.0, 1e-3), a_run(2.0, 1e-2), a_run(3.0, 1e-6), a_run(4.0, f64::INFINITY)];
        let findings = Findings { runs, ..Findings::default() };
        let front: Vec<f64> = findings.front("a").iter().map(|run| run.wall[0]).collect();
        assert_eq!(front, [1.0, 3.0]);
        assert_eq!(findings.best("a").unwrap().wall[0], 3.0);
        // The bound decides, not the error alone.
        assert_eq!(findings.cheapest("a", 1e-6).map(|run| run.wall[0]), None);
        assert_eq!(findings.cheapest("a", 2e-3).map(|run| run.wall[0]), Some(1.0));
    }

    #[test]
    fn runs_come_back_from_a_file() {
        let mut broken = a_run(3.0, f64::INFINITY);
        broken.broke = Some("no step".to_owned());
        let runs = vec![a_run(1.5, 1e-7), broken];
        let findings = Findings { runs, ..Findings::default() };
        let text = findings.to_json().to_string();
        let back = Findings::runs_from_json(&text).unwrap();
        assert_eq!(back.len(), 2);
        assert!(back[0].method.is(&findings.runs[0].method));
        assert_eq!(
            (back[0].wall, back[0].error, back[0].drift.clone()),
            (findings.runs[0].wall, Some(1e-7), findings.runs[0].drift.clone())
        );
        assert_eq!(back[1].error, Some(f64::INFINITY));
        assert!(Findings::runs_from_json("{\"runs\": [{}]}").unwrap_err().contains("`integrator`"));
    }
}
