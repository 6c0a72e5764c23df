//! A work-precision diagram: error against time, both logarithmic, a line for each integrator.
//!
//! In: the runs of a problem. Out: SVG text; what no other run beats in both is ringed. Never: a run without an error.

use super::findings::Findings;
use super::measure::{Method, Run};
use crate::assemble::integrators::INTEGRATORS;
use crate::output::svg::{Svg, colour};
use crate::scene::Precision;

const LEFT: f64 = 84.0;
const TOP: f64 = 64.0;
const WIDTH: f64 = 620.0;
const HEIGHT: f64 = 470.0;
const LEGEND: f64 = 210.0;
/// Errors below this are drawn there.
const LEAST: f64 = 1e-17;
/// Errors above this are drawn there: such a run has nothing to do with the answer.
const MOST: f64 = 10.0;

/// From logarithms to pixels: powers of ten at both ends.
struct View {
    time: (f64, f64),
    error: (f64, f64),
}

impl View {
    fn x(&self, seconds: f64) -> f64 {
        LEFT + WIDTH * (seconds.log10() - self.time.0) / (self.time.1 - self.time.0)
    }

    fn y(&self, error: f64) -> f64 {
        let error = error.clamp(LEAST, MOST).log10();
        TOP + HEIGHT * (self.error.1 - error) / (self.error.1 - self.error.0)
    }

    fn at(&self, run: &Run) -> (f64, f64) {
        (self.x(run.wall[0].max(1e-9)), self.y(run.error.unwrap_or(MOST)))
    }
}

/// The diagram of a problem; `None` where no run has an error.
pub fn diagram(findings: &Findings, case: &str) -> Option<String> {
    let runs: Vec<&Run> = findings.of(case).filter(|run| run.error.is_some_and(f64::is_finite)).collect();
    let decades = |of: &dyn Fn(&Run) -> f64| {
        let logarithms = || runs.iter().map(|run| of(run).log10());
        let (low, high) = (logarithms().fold(f64::INFINITY, f64::min), logarithms().fold(f64::NEG_INFINITY, f64::max));
        (low.floor(), high.ceil().max(low.floor() + 1.0))
    };
    if runs.is_empty() {
        return None;
    }
    let view = View {
        time: decades(&|run| run.wall[0].max(1e-9)),
        error: decades(&|run| run.error.unwrap_or(MOST).clamp(LEAST, MOST)),
    };
    let mut lines: Vec<Vec<&Run>> = Vec::new();
    for &run in &runs {
        match lines.iter_mut().find(|line| is_one_line(line[0], run)) {
            Some(line) => line.push(run),
            None => lines.push(vec![run]),
        }
    }
    let mut names: Vec<&str> = Vec::new();
    for name in lines.iter().map(|line| line[0].method.integrator.name) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let mut svg = Svg::begin(LEFT + WIDTH + LEGEND, TOP + f64::max(HEIGHT + 64.0, 22.0 * (names.len() + 6) as f64));
    svg.text(LEFT, 26.0, "font-size=\"17\" font-weight=\"bold\"", case);
    let answer = findings.answers.iter().find(|(name, _)| name == case).and_then(|(_, answer)| answer.as_ref().ok());
    let told = answer.map_or_else(String::new, |(by, _)| format!("answer: {by}"));
    svg.text(LEFT, 47.0, "fill=\"#555\"", &told);
    axes(&mut svg, &view);
    for line in &lines {
        let colour = colour_of(line[0]);
        let at = |run: &&Run| {
            let (x, y) = view.at(run);
            format!("{x:.1} {y:.1}")
        };
        let path: Vec<String> = line.iter().map(at).collect();
        let dashes = dashes(line[0]);
        svg.line(format!(
            "<path d=\"M{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\" stroke-opacity=\"0.8\" stroke-dasharray=\"{dashes}\"/>",
            path.join("L")
        ));
        for run in line {
            let (x, y) = view.at(run);
            let fill = if run.stable { colour.as_str() } else { "#ffffff" };
            svg.line(format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{fill}\" stroke=\"{colour}\"/>"));
        }
    }
    for (number, name) in names.iter().enumerate() {
        let colour = lines.iter().find(|line| line[0].method.integrator.name == *name).map(|line| colour_of(line[0]));
        let (x, y) = (LEFT + WIDTH + 20.0, TOP + 10.0 + 22.0 * number as f64);
        let colour = colour.unwrap_or_default();
        svg.line(format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{colour}\"/>"));
        svg.text(x + 12.0, y + 4.5, "", name);
    }
    for run in findings.front(case) {
        let (x, y) = view.at(run);
        svg.line(format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"6.5\" fill=\"none\" stroke=\"#000000\" stroke-width=\"1.3\"/>"
        ));
    }
    let (x, y) = (LEFT + WIDTH + 20.0, TOP + 18.0 + 22.0 * names.len() as f64);
    svg.line(format!(
        "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"6.5\" fill=\"none\" stroke=\"#000000\" stroke-width=\"1.3\"/>"
    ));
    svg.text(x + 12.0, y + 4.5, "fill=\"#555\"", "none is faster and nearer");
    svg.line(format!("<circle cx=\"{x:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"#ffffff\" stroke=\"#777777\"/>", y + 22.0));
    svg.text(x + 12.0, y + 26.5, "fill=\"#555\"", "unstable");
    let mut y = y + 22.0;
    for (dashes, words) in WAYS {
        if lines.iter().any(|line| self::dashes(line[0]) == dashes) {
            y += 22.0;
            svg.line(format!(
                "<path d=\"M{:.1} {y:.1}h20\" stroke=\"#777777\" stroke-width=\"1.5\" stroke-dasharray=\"{dashes}\"/>",
                x - 8.0
            ));
            svg.text(x + 18.0, y + 4.5, "fill=\"#555\"", words);
        }
    }
    svg.line("</svg>".to_owned());
    Some(svg.text)
}

/// How lines are dashed that are not as usual.
const WAYS: [(&str, &str); 4] =
    [("6 4", "compensated"), ("2 3", "f32"), ("8 3 2 3", "f32, compensated"), ("12 4", "double-double")];

fn dashes(run: &Run) -> &'static str {
    match (run.method.numbers, run.method.compensated) {
        (Precision::F64, false) => "none",
        (Precision::F64, true) => WAYS[0].0,
        (Precision::F32, false) => WAYS[1].0,
        (Precision::F32, true) => WAYS[2].0,
        (Precision::DoubleDouble, _) => WAYS[3].0,
    }
}

/// Whether two runs are points of one line.
fn is_one_line(one: &Run, other: &Run) -> bool {
    let key = |run: &Run| {
        let Method { integrator, numbers, compensated, backend, .. } = run.method;
        (integrator.name, numbers, compensated, backend)
    };
    key(one) == key(other)
}

/// The same for an integrator in every diagram.
fn colour_of(run: &Run) -> String {
    let number = INTEGRATORS.iter().position(|known| known.name == run.method.integrator.name);
    colour(number.unwrap_or_default(), INTEGRATORS.len())
}

fn axes(svg: &mut Svg, view: &View) {
    let (right, bottom) = (LEFT + WIDTH, TOP + HEIGHT);
    for power in view.time.0 as i32..=view.time.1 as i32 {
        let x = view.x(10f64.powi(power));
        svg.line(format!("<path d=\"M{x:.1} {TOP}V{bottom:.1}\" stroke=\"#e4e4e4\"/>"));
        svg.text(x, bottom + 20.0, "text-anchor=\"middle\"", &format!("1e{power}"));
    }
    let every = ((view.error.1 - view.error.0) as usize).div_ceil(9).max(1);
    for power in (view.error.0 as i32..=view.error.1 as i32).step_by(every) {
        let y = view.y(10f64.powi(power));
        svg.line(format!("<path d=\"M{LEFT} {y:.1}H{right:.1}\" stroke=\"#e4e4e4\"/>"));
        svg.text(LEFT - 8.0, y + 4.5, "text-anchor=\"end\"", &format!("1e{power}"));
    }
    svg.line(format!(
        "<rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"#888\"/>"
    ));
    svg.text(LEFT + WIDTH / 2.0, bottom + 46.0, "text-anchor=\"middle\"", "time of the run [s]");
    let (x, y) = (22.0, TOP + HEIGHT / 2.0);
    let turned = format!("text-anchor=\"middle\" transform=\"rotate(-90 {x:.1} {y:.1})\"");
    svg.text(x, y, &turned, "largest error, by the scale of each quantity");
}
