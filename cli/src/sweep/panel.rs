//! One panel of a picture: lines over an axis, or a map of coloured cells.
//!
//! In: axes, a scale, numbers. Out: SVG, in its place. Never: a number for a run that has none: lines have a gap there, and
//! a cross marks it.

use super::scale::{Axis, Scale};
use crate::output::picture::shortened;
use crate::output::svg::{Svg, colour};

/// Room of the plot itself, in pixels.
const WIDTH: f64 = 400.0;
const HEIGHT: f64 = 260.0;
const LEFT: f64 = 88.0;
const TOP: f64 = 40.0;
const BOTTOM: f64 = 62.0;
/// For names of lines, or for a bar of colours.
const RIGHT: f64 = 170.0;
/// A panel with all that belongs to it.
pub(super) const SIZE: (f64, f64) = (LEFT + WIDTH + RIGHT, TOP + HEIGHT + BOTTOM);

/// More points than this are a line without dots, and more lines have no names.
const MOST_DOTS: usize = 80;
const MOST_NAMES: usize = 12;

/// Dark to bright, so that it can be read without colours: five of viridis, by Smith and van der Walt.
const HEAT: [[f64; 3]; 5] =
    [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 37.0]];

/// A panel, its upper left corner at a place of the picture.
#[derive(Debug)]
pub(super) struct Panel<'s> {
    pub(super) svg: &'s mut Svg,
    pub(super) corner: (f64, f64),
    pub(super) title: String,
}

/// A line: its name, and a number for each value of the axis, where there is one.
pub(super) type Line = (String, Vec<Option<f64>>);

impl Panel<'_> {
    fn x(&self, place: f64) -> f64 {
        self.corner.0 + LEFT + WIDTH * place
    }

    fn y(&self, place: f64) -> f64 {
        self.corner.1 + TOP + HEIGHT * (1.0 - place)
    }

    /// Title, grid, ticks, the name of the axis.
    fn frame(&mut self, across: &Axis, ticks: &[(f64, String)], grid: bool) {
        let (left, right, top, bottom) = (self.x(0.0), self.x(1.0), self.y(1.0), self.y(0.0));
        self.svg.text(left, top - 12.0, "font-weight=\"bold\"", &self.title);
        for (place, label) in &across.ticks {
            let x = self.x(*place);
            if grid {
                self.svg.line(format!("<path d=\"M{x:.1} {top:.1}V{bottom:.1}\" stroke=\"#e4e4e4\"/>"));
            }
            self.svg.text(x, bottom + 18.0, "text-anchor=\"middle\" font-size=\"11\"", label);
        }
        for (place, label) in ticks {
            let y = self.y(*place);
            if grid {
                self.svg.line(format!("<path d=\"M{left:.1} {y:.1}H{right:.1}\" stroke=\"#e4e4e4\"/>"));
            }
            self.svg.text(left - 8.0, y + 4.0, "text-anchor=\"end\" font-size=\"11\"", label);
        }
        self.svg.text(self.x(0.5), bottom + 42.0, "text-anchor=\"middle\"", &across.name);
    }

    /// Drawn last, above what touches it.
    fn border(&mut self) {
        let (left, top) = (self.x(0.0), self.y(1.0));
        self.svg.line(format!(
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"#888\"/>"
        ));
    }

    fn cross(&mut self, x: f64, y: f64, colour: &str) {
        self.svg.line(format!(
            "<path d=\"M{:.1} {:.1}l8 8m0 -8l-8 8\" stroke=\"{colour}\" stroke-width=\"1.5\"/>",
            x - 4.0,
            y - 4.0
        ));
    }

    /// Lines over an axis, by the scale of their numbers.
    pub(super) fn lines(&mut self, across: &Axis, scale: &Scale, lines: &[Line], names: Option<&str>) {
        self.frame(across, &scale.ticks(), true);
        for (number, (_, values)) in lines.iter().enumerate() {
            let colour = colour(number, lines.len());
            let (mut path, mut gap) = (String::new(), true);
            for (place, value) in across.places.iter().zip(values) {
                let x = self.x(*place);
                match value {
                    Some(value) => {
                        let y = self.y(scale.at(*value));
                        path += &format!("{}{x:.1} {y:.1}", if gap { 'M' } else { 'L' });
                        if values.len() <= MOST_DOTS {
                            self.svg.line(format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{colour}\"/>"));
                        }
                    }
                    None => self.cross(x, self.y(0.0) - 8.0, &colour),
                }
                gap = value.is_none();
            }
            if path.contains('L') {
                self.svg.line(format!("<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"/>"));
            }
        }
        self.border();
        let Some(names) = names else { return };
        let (x, mut y) = (self.x(1.0) + 14.0, self.y(1.0) + 10.0);
        self.svg.text(x, y, "fill=\"#555\" font-size=\"11\"", names);
        for (number, (name, _)) in lines.iter().enumerate().take(MOST_NAMES) {
            y += 18.0;
            let colour = colour(number, lines.len());
            self.svg.line(format!("<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{colour}\"/>", x + 4.0, y - 4.0));
            self.svg.text(x + 14.0, y, "font-size=\"11\"", &shortened(name));
        }
        if lines.len() > MOST_NAMES {
            self.svg.text(x + 14.0, y + 18.0, "fill=\"#555\" font-size=\"11\"", "and others");
        }
    }

    /// A cell for each pair of values, coloured by its number: `cells[up][across]`.
    pub(super) fn map(&mut self, across: &Axis, up: &Axis, scale: &Scale, cells: &[Vec<Option<f64>>]) {
        self.frame(across, &up.ticks, false);
        let (wide, tall) = (WIDTH / across.places.len().max(1) as f64, HEIGHT / up.places.len().max(1) as f64);
        for (row, place) in cells.iter().zip(&up.places) {
            for (value, along) in row.iter().zip(&across.places) {
                let (x, y) = (self.x(*along), self.y(*place));
                let fill = value.map_or_else(|| "#dddddd".to_owned(), |value| heat(scale.at(value)));
                self.svg.line(format!(
                    "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{wide:.1}\" height=\"{tall:.1}\" fill=\"{fill}\" stroke=\"{fill}\" stroke-width=\"0.3\"/>",
                    x - 0.5 * wide,
                    y - 0.5 * tall,
                ));
                if value.is_none() {
                    self.cross(x, y, "#777777");
                }
            }
        }
        self.border();
        let (x, y) = (self.corner.0 + 18.0, self.y(0.5));
        let turned = format!("text-anchor=\"middle\" transform=\"rotate(-90 {x:.1} {y:.1})\"");
        self.svg.text(x, y, &turned, &up.name);
        self.bar(scale);
    }

    /// What the colours mean.
    fn bar(&mut self, scale: &Scale) {
        const PARTS: usize = 40;
        let (x, part) = (self.x(1.0) + 18.0, HEIGHT / PARTS as f64);
        for index in 0..PARTS {
            let (fill, y) = (heat((index as f64 + 0.5) / PARTS as f64), self.y((index + 1) as f64 / PARTS as f64));
            // A little taller than its part, so that no gap shows.
            let tall = part + if index > 0 { 0.5 } else { 0.0 };
            self.svg
                .line(format!("<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"16\" height=\"{tall:.2}\" fill=\"{fill}\"/>"));
        }
        for (place, text) in scale.ticks() {
            let y = self.y(place);
            self.svg.line(format!("<path d=\"M{:.1} {y:.1}h4\" stroke=\"#555\"/>", x + 16.0));
            self.svg.text(x + 24.0, y + 4.0, "font-size=\"11\"", &text);
        }
    }
}

/// The colour of a place between 0 and 1.
fn heat(place: f64) -> String {
    let along = place.clamp(0.0, 1.0) * (HEAT.len() - 1) as f64;
    let index = (along as usize).min(HEAT.len() - 2);
    let part = along - index as f64;
    let [red, green, blue] =
        [0, 1, 2].map(|k| (HEAT[index][k] * (1.0 - part) + HEAT[index + 1][k] * part).round() as u8);
    format!("#{red:02x}{green:02x}{blue:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_go_from_dark_to_bright() {
        assert_eq!([heat(0.0), heat(0.5), heat(1.0)], ["#440154", "#21918c", "#fde725"]);
        assert_eq!((heat(-1.0), heat(2.0)), (heat(0.0), heat(1.0)));
    }
}
