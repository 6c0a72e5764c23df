//! The picture of a sweep: a panel for each thing that was measured.
//!
//! In: an ensemble, the records of all its runs. Out: SVG text that depends on nothing else. Never: a run without a number
//! as if it had one.
//!
//! One thing varies: lines over it. Two: a map of cells, or, where one of them is words (integrators), a line for each word.
//! More: a panel for each combination of those before the last two. What was measured is shown; where nothing was, the
//! drifts of energy and momenta, or else the steps.

use super::ensemble::Ensemble;
use super::panel::{Line, Panel, SIZE};
use super::record::{DRIFTS, Record};
use super::scale::{Axis, Scale, label};
use super::vary::Vary;
use crate::output::svg::Svg;

/// More panels than this are a wall; a table serves better.
const MOST_PANELS: usize = 24;
const COLUMNS: usize = 3;
/// Room for the title.
const HEAD: f64 = 64.0;

/// Something that each run has a number for, or no number.
struct Quantity {
    name: String,
    values: Vec<Option<f64>>,
    /// One for all panels, so that they compare.
    scale: Scale,
}

/// The picture; none where no run has a number. `records` are those of all runs, in their order.
pub fn diagram(ensemble: &Ensemble, records: &[Record]) -> Option<String> {
    let quantities = quantities(ensemble, records);
    let (before, last) = ensemble.varies.split_at(ensemble.varies.len().saturating_sub(2));
    let combinations: usize = before.iter().map(|vary| vary.values.len()).product();
    let panels = quantities.len() * combinations;
    if panels == 0 || last.is_empty() {
        return None;
    }
    let shown = panels.min(MOST_PANELS);
    let columns = if quantities.len() > 1 { quantities.len() } else { combinations }.min(COLUMNS);
    let (width, height) = (SIZE.0 * columns as f64, HEAD + SIZE.1 * shown.div_ceil(columns) as f64);
    let mut svg = Svg::begin(width.max(9.6 * ensemble.title.chars().count() as f64 + 40.0), height + 24.0);
    svg.text(24.0, 26.0, "font-size=\"17\" font-weight=\"bold\"", &ensemble.title);
    svg.text(24.0, 47.0, "fill=\"#555\"", &counts(records));
    for index in 0..shown {
        let (combination, quantity) = (index / quantities.len(), &quantities[index % quantities.len()]);
        let corner = ((index % columns) as f64 * SIZE.0, HEAD + (index / columns) as f64 * SIZE.1);
        let title = title(ensemble, before, combination, quantity);
        let panel = Panel { svg: &mut svg, corner, title };
        draw(ensemble, last, combination, quantity, panel);
    }
    if panels > shown {
        let text = format!("and {} panels more: see the table", panels - shown);
        svg.text(24.0, height + 8.0, "fill=\"#555\"", &text);
    }
    svg.line("</svg>".to_owned());
    Some(svg.text)
}

fn counts(records: &[Record]) -> String {
    let failed = records.iter().filter(|record| record.fault.is_some()).count();
    let failed = if failed == 0 { String::new() } else { format!(", {failed} failed (crosses)") };
    format!("{} runs{failed}", records.len())
}

fn quantities(ensemble: &Ensemble, records: &[Record]) -> Vec<Quantity> {
    let quantity = |name: String, of: &dyn Fn(&Record) -> Option<f64>| {
        let values: Vec<Option<f64>> =
            records.iter().map(|record| of(record).filter(|value| value.is_finite())).collect();
        let known: Vec<f64> = values.iter().flatten().copied().collect();
        Scale::of(&known, false, 0.05).map(|scale| Quantity { name, values, scale })
    };
    let measured = ensemble.measures.iter().enumerate().filter_map(|(place, measure)| {
        let unit = if measure.unit.is_empty() { String::new() } else { format!(" [{}]", measure.unit) };
        quantity(format!("{}{unit}", measure.text), &|record| record.measures.get(place).copied().flatten())
    });
    let measured: Vec<Quantity> = measured.collect();
    if !measured.is_empty() {
        return measured;
    }
    let drifts =
        DRIFTS.iter().filter_map(|(name, column)| quantity(column.replace('_', " "), &|record| record.drift(name)));
    // A drift that is 0 in all runs tells nothing.
    let drifts: Vec<Quantity> = drifts.filter(|one| one.values.iter().flatten().any(|value| *value != 0.0)).collect();
    if !drifts.is_empty() {
        return drifts;
    }
    let steps = quantity("steps".to_owned(), &|record| record.fault.is_none().then_some(record.steps as f64));
    steps.into_iter().collect()
}

/// The quantity, and the values of what is not on an axis.
fn title(ensemble: &Ensemble, before: &[Vary], combination: usize, quantity: &Quantity) -> String {
    let inner = ensemble.runs() / before.iter().map(|vary| vary.values.len()).product::<usize>().max(1);
    let indices = ensemble.indices(1 + combination * inner);
    let at = before.iter().zip(indices).map(|(vary, index)| format!("{}={}", vary.path, label(&vary.values[index])));
    std::iter::once(quantity.name.clone()).chain(at).collect::<Vec<_>>().join(", ")
}

/// One panel: of the runs of one combination, over the last one or two that vary.
fn draw(ensemble: &Ensemble, last: &[Vary], combination: usize, quantity: &Quantity, mut panel: Panel<'_>) {
    let inner: usize = last.iter().map(|vary| vary.values.len()).product();
    let value = |index: usize| quantity.values.get(combination * inner + index).copied().flatten();
    let (one, two) = match last {
        [one, two] => (one, two),
        _ => {
            let Some(vary) = ensemble.varies.last() else { return };
            let line: Line = (String::new(), (0..inner).map(value).collect());
            return panel.lines(&Axis::by_size(vary), &quantity.scale, &[line], None);
        }
    };
    let many = two.values.len();
    let at = |first: usize, second: usize| value(first * many + second);
    let lines = |names: &Vary, of: &dyn Fn(usize) -> Vec<Option<f64>>| -> Vec<Line> {
        names.values.iter().enumerate().map(|(index, name)| (name.clone(), of(index))).collect()
    };
    match (one.numbers().is_some(), two.numbers().is_some()) {
        (false, true) => {
            let lines = lines(one, &|first| (0..many).map(|second| at(first, second)).collect());
            panel.lines(&Axis::by_size(two), &quantity.scale, &lines, Some(&one.path));
        }
        (true, false) => {
            let lines = lines(two, &|second| (0..one.values.len()).map(|first| at(first, second)).collect());
            panel.lines(&Axis::by_size(one), &quantity.scale, &lines, Some(&two.path));
        }
        _ => {
            let row = |second: usize| (0..one.values.len()).map(|first| at(first, second)).collect();
            let cells: Vec<Vec<Option<f64>>> = (0..many).map(row).collect();
            panel.map(&Axis::in_order(one), &Axis::in_order(two), &quantity.scale, &cells);
        }
    }
}
