//! What a study has found, as a table for people.
//!
//! In: findings. Out: text: a line for each of many problems, or for each integrator where there is one. Never: a number
//! that no run has.

use std::fmt::Write;

use super::budget::Budget;
use super::findings::{Findings, LEVELS, Told, number_type};
use super::measure::{Method, Run};
use super::problem::Problem;
use crate::scene::Precision;

/// The table.
pub fn table(findings: &Findings) -> String {
    let mut text = match &findings.answers[..] {
        [(case, answer)] => one(findings, case, answer),
        _ => many(findings),
    };
    refusals(findings, &mut text);
    text
}

/// What meets a budget at the least cost, with the evidence; or how near anything comes.
pub fn choice(findings: &Findings, problem: &Problem, budget: &Budget) -> String {
    let within = format!("{}: an error of at most {:e}", problem.id, budget.error);
    let Some(run) = budget.choice(problem, findings) else {
        let nearest = findings.best(&problem.id).and_then(|run| run.bound);
        return match (nearest, budget.fps) {
            (None, _) => format!("{within} cannot be shown: there is no answer to measure it by\n"),
            (Some(bound), None) => format!("{within} is met by no run: the nearest one comes to {bound:.1e}\n"),
            (Some(bound), Some(fps)) => format!(
                "{within}, at {fps} frames a second, is met by no run: the nearest one, at any speed, comes to {bound:.1e}\n"
            ),
        };
    };
    let Method { numbers, compensated, .. } = run.method;
    let kept = if compensated { ", compensated" } else { "" };
    let [median, shortest, longest] = run.wall.map(time);
    let mut text = format!(
        "{within} costs least by {} with {}, in {}{kept}:\n  error {:.1e}, at most {:.1e}; {median} ({shortest} to {longest}); \
         {} evaluations\n",
        run.method.integrator.name,
        run.method.setting_words(),
        number_type(numbers),
        run.error.unwrap_or(f64::NAN),
        run.bound.unwrap_or(f64::NAN),
        run.evaluations,
    );
    if let Some(fps) = budget.fps {
        let share = 100.0 * run.wall[0] / problem.length();
        _ = writeln!(text, "  {share:.2} % of the time of a frame, at {fps} frames a second");
    }
    text
}

/// Who cannot do what: integrators that refuse the same problems, in one line.
fn refusals(findings: &Findings, text: &mut String) {
    let mut integrators: Vec<((&str, bool), Vec<&str>, &str)> = Vec::new();
    for refusal in &findings.refusals {
        let who = (refusal.integrator.as_str(), refusal.longer_steps);
        match integrators.iter_mut().find(|(known, ..)| *known == who) {
            Some((_, cases, _)) => cases.push(&refusal.case),
            None => integrators.push((who, vec![&refusal.case], &refusal.reason)),
        }
    }
    while let Some(((_, longer), cases, reason)) = integrators.first().cloned() {
        let same = |(_, also): (&str, bool), others: &[&str]| also == longer && others == cases;
        let names: Vec<&str> =
            integrators.iter().filter(|(who, others, _)| same(*who, others)).map(|((name, _), ..)| *name).collect();
        integrators.retain(|(who, others, _)| !same(*who, others));
        let steps = if longer { " with longer steps" } else { "" };
        let of = if findings.answers.len() == 1 {
            String::new()
        } else {
            format!(" for {} of {} cases ({})", cases.len(), findings.answers.len(), cases.join(", "))
        };
        // Writing to a string cannot fail.
        _ = writeln!(text, "\nno {}{steps}{of}: {reason}", names.join(", "));
    }
}

/// A time in a unit that suits it.
fn time(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s >= 1.0 => (s, "s"),
        s if s >= 1e-3 => (s * 1e3, "ms"),
        s => (s * 1e6, "us"),
    };
    format!("{} {unit}", crate::output::rounded(value, 3))
}

fn error(error: Option<f64>) -> String {
    match error {
        None => "-".to_owned(),
        Some(error) if error.is_finite() => format!("{error:.0e}"),
        Some(_) => "broke".to_owned(),
    }
}

/// The integrator of a run, with the number type where that is not the usual one.
fn by(run: &Run) -> String {
    let Method { integrator, numbers, .. } = run.method;
    if numbers == Precision::F64 {
        integrator.name.to_owned()
    } else {
        format!("{}, {}", integrator.name, number_type(numbers))
    }
}

/// A line for each problem: the nearest run, and the fastest at some errors.
fn many(findings: &Findings) -> String {
    let width = findings.answers.iter().map(|(case, _)| case.len()).max().unwrap_or(4).max(4);
    let mut text = format!("{:width$}  {:>7}  {:>6}  {:30}", "case", "nearest", "floors", "by");
    for level in LEVELS {
        _ = write!(text, "  {:39}", format!("fastest at {level:e}"));
    }
    text = text.trim_end().to_owned();
    text.push('\n');
    let mut reached = [0, 0];
    for (case, _) in &findings.answers {
        let best = findings.best(case);
        let by_floor = findings.of(case).filter_map(|run| run.by_floor).fold(f64::INFINITY, f64::min);
        if by_floor.is_finite() {
            reached[0] += usize::from(by_floor <= 1.0);
            reached[1] += 1;
        }
        let floors =
            if by_floor.is_finite() { crate::output::rounded(by_floor, 2).to_string() } else { "-".to_owned() };
        let mut line = format!(
            "{case:width$}  {:>7}  {floors:>6}  {:30}",
            error(best.and_then(|run| run.error)),
            best.map_or(String::new(), by)
        );
        for level in LEVELS {
            let words = findings
                .cheapest(case, level)
                .map_or_else(|| "-".to_owned(), |run| format!("{:>8} {}", time(run.wall[0]), by(run)));
            _ = write!(line, "  {words:39}");
        }
        text += line.trim_end();
        text.push('\n');
    }
    let [within, known] = reached;
    if known > 0 {
        _ = writeln!(
            text,
            "\nfloors: the error by max(1e-12, ten times what half a rounding of the input becomes); at most 1 on {within} \
             of {known} cases"
        );
    }
    text
}

/// A line for each run that nothing beats in both time and error; then the best of each integrator.
fn one(findings: &Findings, case: &str, answer: &Told) -> String {
    let mut text = match answer {
        Ok((by, uncertainty)) if *uncertainty > 0.0 => {
            format!("answer: {by}; it may be wrong by {uncertainty:.0e}, which each bound counts in\n")
        }
        Ok((by, _)) => format!("answer: {by}\n"),
        Err(reason) => format!("no answer: {reason}\nwithout one there are times and drifts, but no errors\n"),
    };
    let line = |text: &mut String, run: &Run| {
        let drift: Vec<String> = run.drift.iter().map(|(name, value)| format!("{name} {value:.0e}")).collect();
        let mut words: Vec<String> = run.method.compensated.then(|| "compensated".to_owned()).into_iter().collect();
        words.extend((run.method.numbers != Precision::F64).then(|| number_type(run.method.numbers).to_owned()));
        words.extend((!drift.is_empty()).then(|| format!("drift: {}", drift.join(", "))));
        words.extend((!run.stable && run.broke.is_none()).then(|| "unstable".to_owned()));
        words.extend(run.broke.clone());
        _ = writeln!(
            text,
            "{:>9}  {:>7}  {:>7}  {:>10}  {:20} {:16} {}",
            time(run.wall[0]),
            error(run.error),
            error(run.bound),
            run.evaluations,
            run.method.integrator.name,
            run.method.setting_words(),
            words.join("; ")
        );
    };
    let head = format!("{:>9}  {:>7}  {:>7}  {:>10}  integrator", "time", "error", "bound", "evaluations");
    let front = findings.front(case);
    if !front.is_empty() {
        _ = writeln!(text, "\nnone is faster and nearer:\n{head}");
        front.iter().for_each(|run| line(&mut text, run));
    }
    _ = writeln!(text, "\nall:\n{head}");
    findings.of(case).for_each(|run| line(&mut text, run));
    text
}
