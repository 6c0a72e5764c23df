//! Trajectories as a picture, in plain SVG: the two axes with the largest extent, both to the same scale.
//!
//! In: trails. Out: SVG text with axes, ticks and units, a colour for each row, start and end, links at the end, a legend
//! where the rows are few. Never: a script, a font or a file from elsewhere.

use std::fmt::{self, Write};

use super::svg::{Svg, colour};
use super::trails::{MOST_TRAILS, Trail};
pub use super::trails::{Trails, worth_adding};
use super::{rounded, title};
use crate::scene::Scene;

/// Room of the plot, in pixels.
const PLOT: (f64, f64) = (720.0, 600.0);
const LEFT: f64 = 84.0;
const TOP: f64 = 64.0;
const BOTTOM: f64 = 64.0;
const LEGEND: f64 = 190.0;
/// More rows than this have no legend; of rows without labels, more than the second.
const MOST_NAMES: [usize; 2] = [24, 12];
/// Points nearer than this, in pixels, are one.
const NEAR: f64 = 0.4;

/// A picture of trails.
#[derive(Debug)]
pub struct Picture {
    text: String,
}

impl fmt::Display for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// From places to pixels.
struct View {
    /// Numbers of the axis to the right and of the axis upwards.
    axes: [usize; 2],
    low: [f64; 2],
    scale: f64,
    width: f64,
    height: f64,
}

impl View {
    /// The part of space in which all trails lie; `None` where there is none.
    fn of(trails: &[Trail]) -> Option<Self> {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for trail in trails {
            for place in trail.moments.iter().chain([&trail.last]).flat_map(|places| places.chunks_exact(3)) {
                for axis in 0..3 {
                    if place[axis].is_finite() {
                        low[axis] = low[axis].min(place[axis]);
                        high[axis] = high[axis].max(place[axis]);
                    }
                }
            }
        }
        let extent = |axis: usize| high[axis] - low[axis];
        if !(0..3).all(|axis| extent(axis).is_finite()) {
            return None;
        }
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| extent(b).total_cmp(&extent(a)));
        let mut axes = [order[0], order[1]];
        axes.sort_unstable();
        // A line, or a point, is seen from a distance that suits its length, or its distance from the origin.
        let largest = extent(order[0]);
        let size = if largest > 0.0 { largest } else { low.iter().fold(0.0_f64, |a, b| a.max(b.abs())).max(1.0) };
        let padded = |axis: usize| (extent(axis) * 1.1).max(0.35 * size);
        let (wide, tall) = (padded(axes[0]), padded(axes[1]));
        let scale = (PLOT.0 / wide).min(PLOT.1 / tall);
        let middle = |axis: usize, size: f64| 0.5 * (low[axis] + high[axis]) - 0.5 * size;
        let view = View {
            axes,
            low: [middle(axes[0], wide), middle(axes[1], tall)],
            scale,
            width: wide * scale,
            height: tall * scale,
        };
        (scale.is_finite() && scale > 0.0).then_some(view)
    }

    fn x(&self, value: f64) -> f64 {
        LEFT + (value - self.low[0]) * self.scale
    }

    fn y(&self, value: f64) -> f64 {
        TOP + self.height - (value - self.low[1]) * self.scale
    }

    fn pixel(&self, places: &[f64], row: usize) -> (f64, f64) {
        (self.x(places[3 * row + self.axes[0]]), self.y(places[3 * row + self.axes[1]]))
    }
}

impl Picture {
    /// The picture of `trails`; none where no row has a place.
    pub fn new(scene: &Scene, trails: &Trails) -> Option<Self> {
        let view = View::of(&trails.list)?;
        let rows: usize = trails.list.iter().map(|trail| trail.rows).sum();
        let labelled = trails.list.iter().all(|trail| scene.domain(&trail.domain).is_some_and(|d| d.labels.is_some()));
        let named = rows <= MOST_NAMES[usize::from(!labelled)];
        let title = title(scene, trails.end).unwrap_or_else(|| "trajectories".to_owned());
        let legend = if named || !trails.links.is_empty() { LEGEND } else { 24.0 };
        let width = (LEFT + view.width + legend).max(LEFT + 24.0 + 9.6 * title.chars().count() as f64);
        let names = if named { rows as f64 } else { 0.0 };
        let height = (TOP + view.height + BOTTOM).max(TOP + 20.0 * (names + 4.0));
        let mut svg = Svg::begin(width, height);
        svg.text(LEFT, 26.0, "font-size=\"17\" font-weight=\"bold\"", &title);
        let times = format!("from {} to {}", duration(trails.begin), duration(trails.end));
        svg.text(LEFT, 47.0, "fill=\"#555\"", &times);
        svg.axes(&view);
        svg.line(format!(
            "<clipPath id=\"plot\"><rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{:.1}\" height=\"{:.1}\"/></clipPath>",
            view.width, view.height
        ));
        svg.line("<g clip-path=\"url(#plot)\">".to_owned());
        svg.links(&view, trails);
        let mut first = 0;
        for trail in &trails.list {
            svg.trail(&view, trail, first, rows);
            first += trail.rows;
        }
        svg.line("</g>".to_owned());
        if legend == LEGEND {
            svg.legend(&view, scene, trails, named);
        }
        svg.line("</svg>".to_owned());
        Some(Picture { text: svg.text })
    }
}

impl Svg {
    /// Frame, grid, ticks, names of the axes with their unit.
    fn axes(&mut self, view: &View) {
        let (right, bottom) = (LEFT + view.width, TOP + view.height);
        let size = [view.width / view.scale, view.height / view.scale];
        let (unit, metres) = length_unit(size[0].max(size[1]));
        // Both axes have the same distance between ticks; the shorter one at least two ticks.
        let step = tick_step((size[0].max(size[1]) / 7.0).min(size[0].min(size[1]) / 2.0) / metres);
        for (axis, size) in size.iter().enumerate() {
            let low = view.low[axis] / metres;
            let mut number = (low / step).ceil();
            while number * step <= low + size / metres {
                let value = number * step;
                let label = tick_label(value, step);
                if axis == 0 {
                    let x = view.x(value * metres);
                    self.line(format!("<path d=\"M{x:.1} {TOP}V{bottom:.1}\" stroke=\"#e4e4e4\"/>"));
                    self.text(x, bottom + 20.0, "text-anchor=\"middle\"", &label);
                } else {
                    let y = view.y(value * metres);
                    self.line(format!("<path d=\"M{LEFT} {y:.1}H{right:.1}\" stroke=\"#e4e4e4\"/>"));
                    self.text(LEFT - 8.0, y + 4.5, "text-anchor=\"end\"", &label);
                }
                number += 1.0;
            }
        }
        self.line(format!(
            "<rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"none\" stroke=\"#888\"/>",
            view.width, view.height
        ));
        let name = |axis: usize| format!("{} [{unit}]", ["x", "y", "z"][view.axes[axis]]);
        self.text(LEFT + view.width / 2.0, bottom + 46.0, "text-anchor=\"middle\"", &name(0));
        let (x, y) = (22.0, TOP + view.height / 2.0);
        self.text(x, y, &format!("text-anchor=\"middle\" transform=\"rotate(-90 {x:.1} {y:.1})\""), &name(1));
    }

    /// Links at the last moment: a line through the rows of each, closed where they are more than two.
    fn links(&mut self, view: &View, trails: &Trails) {
        for (domain, ends) in &trails.links {
            let Some(trail) = trails.list.iter().find(|trail| trail.domain == *domain) else { continue };
            let mut path = String::new();
            for (index, &row) in ends.iter().enumerate().filter(|(_, row)| (**row as usize) < trail.rows) {
                let (x, y) = view.pixel(&trail.last, row as usize);
                // Writing to a string cannot fail.
                _ = write!(path, "{}{x:.1} {y:.1}", if index == 0 { 'M' } else { 'L' });
            }
            let close = if ends.len() > 2 { "Z" } else { "" };
            if !path.contains("NaN") && path.starts_with('M') {
                self.line(format!("<path d=\"{path}{close}\" fill=\"none\" stroke=\"#9a9a9a\" stroke-width=\"1.2\"/>"));
            }
        }
    }

    /// The ways of the rows of one domain, then their starts and ends above them.
    fn trail(&mut self, view: &View, trail: &Trail, first: usize, rows: usize) {
        let few = trail.rows <= MOST_TRAILS;
        let (small, large) = if few { (3.5, 4.0) } else { (1.0, 1.6) };
        for row in (0..trail.rows).filter(|_| few) {
            let places = trail.along(row, view.axes[0]).zip(trail.along(row, view.axes[1]));
            let mut path = String::new();
            let mut before: Option<(f64, f64)> = None;
            for (x, y) in places.map(|(x, y)| (view.x(x), view.y(y))).filter(|(x, y)| x.is_finite() && y.is_finite()) {
                let moved = before.is_none_or(|(a, b)| (x - a).abs().max((y - b).abs()) >= NEAR);
                if moved {
                    _ = write!(path, "{}{x:.1} {y:.1}", if path.is_empty() { 'M' } else { 'L' });
                    before = Some((x, y));
                }
            }
            let colour = colour(first + row, rows);
            if path.contains('L') {
                let style = "fill=\"none\" stroke-width=\"1.4\" stroke-linejoin=\"round\" stroke-opacity=\"0.8\"";
                self.line(format!("<path d=\"{path}\" {style} stroke=\"{colour}\"/>"));
            }
        }
        for row in 0..trail.rows {
            let colour = colour(first + row, rows);
            let begin = trail.moments.first().map(|places| view.pixel(places, row));
            if let Some((x, y)) = begin.filter(|(x, y)| x.is_finite() && y.is_finite()) {
                let fill = if few { "#ffffff" } else { "none" };
                let (opacity, width) = if few { (1.0, 1.4) } else { (0.25, 0.8) };
                self.line(format!(
                    "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{small}\" fill=\"{fill}\" stroke=\"{colour}\" stroke-width=\"{width}\" opacity=\"{opacity}\"/>"
                ));
            }
        }
        for row in 0..trail.rows {
            let (x, y) = view.pixel(&trail.last, row);
            if x.is_finite() && y.is_finite() {
                let colour = colour(first + row, rows);
                self.line(format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{large}\" fill=\"{colour}\"/>"));
            }
        }
    }

    fn legend(&mut self, view: &View, scene: &Scene, trails: &Trails, named: bool) {
        let rows: usize = trails.list.iter().map(|trail| trail.rows).sum();
        let x = LEFT + view.width + 20.0;
        let mut y = TOP + 10.0;
        let mut first = 0;
        for trail in trails.list.iter().filter(|_| named) {
            let labels = scene.domain(&trail.domain).and_then(|domain| domain.labels.as_deref()).unwrap_or_default();
            for row in 0..trail.rows {
                let colour = colour(first + row, rows);
                self.line(format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{colour}\"/>"));
                let name = labels.get(row).cloned().unwrap_or_else(|| format!("{} {row}", trail.domain));
                self.text(x + 12.0, y + 4.5, "", &shortened(&name));
                y += 20.0;
            }
            first += trail.rows;
        }
        y += 8.0;
        let grey = "stroke=\"#777\" stroke-width=\"1.4\"";
        self.line(format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\" fill=\"#ffffff\" {grey}/>"));
        self.text(x + 12.0, y + 4.5, "fill=\"#555\"", "start");
        self.line(format!("<circle cx=\"{:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"#777\"/>", x + 70.0));
        self.text(x + 82.0, y + 4.5, "fill=\"#555\"", "end");
        if !trails.links.is_empty() {
            y += 20.0;
            self.line(format!("<path d=\"M{:.1} {y:.1}h14\" {grey}/>", x - 6.0));
            self.text(x + 12.0, y + 4.5, "fill=\"#555\"", "link at the end");
        }
    }
}

/// A unit in which `extent` is a number of a few digits, and its metres.
fn length_unit(extent: f64) -> (&'static str, f64) {
    const UNITS: [(&str, f64, f64); 6] = [
        ("au", 149_597_870_700.0, 1.5e10),
        ("km", 1e3, 1e4),
        ("m", 1.0, 0.5),
        ("mm", 1e-3, 5e-4),
        ("µm", 1e-6, 5e-7),
        ("nm", 1e-9, 0.0),
    ];
    let found = UNITS.iter().find(|(_, _, least)| extent >= *least);
    found.map_or(("m", 1.0), |(unit, metres, _)| (unit, *metres))
}

/// 1, 2 or 5 times a power of ten, at least `size`.
pub(crate) fn tick_step(size: f64) -> f64 {
    let power = 10f64.powf(size.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|factor| factor * power).find(|step| *step >= size * 0.999).unwrap_or(power)
}

pub(crate) fn tick_label(value: f64, step: f64) -> String {
    let places = (-step.log10().floor()).max(0.0);
    if places > 6.0 || value.abs() >= 1e7 {
        return rounded(value, 6).to_string();
    }
    let text = format!("{value:.*}", places as usize);
    if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') { "0".to_owned() } else { text }
}

/// A time in a unit that suits it.
pub(crate) fn duration(seconds: f64) -> String {
    match seconds.abs() {
        size if size >= 2.0 * 31_557_600.0 => format!("{} yr", rounded(seconds / 31_557_600.0, 4)),
        size if size >= 2.0 * 86_400.0 => format!("{} d", rounded(seconds / 86_400.0, 4)),
        size if size == 0.0 || size >= 0.1 => format!("{} s", rounded(seconds, 5)),
        _ => format!("{} ms", rounded(seconds * 1e3, 4)),
    }
}

pub(crate) fn shortened(name: &str) -> String {
    if name.chars().count() <= 20 { name.to_owned() } else { name.chars().take(19).chain(['…']).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks() {
        assert_eq!([tick_step(0.9), tick_step(1.3), tick_step(34.0), tick_step(0.07)], [1.0, 2.0, 50.0, 0.1]);
        assert_eq!(
            [tick_label(0.30000000000000004, 0.1), tick_label(-0.0, 0.5), tick_label(50.0, 10.0)],
            ["0.3", "0", "50"]
        );
        assert_eq!(length_unit(5e12).0, "au");
        assert_eq!(length_unit(2e4).0, "km");
        assert_eq!(length_unit(0.02).0, "mm");
    }
}
