//! SVG text that is being written: lines, words, colours.
//!
//! In: shapes. Out: text. Never: a script, a font or a file from elsewhere.

const COLOURS: [&str; 12] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b8860b", "#56b4e9", "#7f3c8d", "#8c564b", "#e41a1c", "#4d4d4d",
    "#66a61e", "#17becf",
];

/// SVG text that is being written.
#[derive(Debug, Default)]
pub(crate) struct Svg {
    pub(crate) text: String,
}

impl Svg {
    /// The head of a picture of this size, in pixels, on white.
    pub(crate) fn begin(width: f64, height: f64) -> Self {
        let mut svg = Svg::default();
        svg.line(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"sans-serif\" font-size=\"13\">"
        ));
        svg.line(format!("<rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"#ffffff\"/>"));
        svg
    }

    pub(crate) fn line(&mut self, line: String) {
        self.text += &line;
        self.text.push('\n');
    }

    pub(crate) fn text(&mut self, x: f64, y: f64, style: &str, words: &str) {
        self.line(format!("<text x=\"{x:.1}\" y=\"{y:.1}\" {style}>{}</text>", escaped(words)));
    }
}

/// The colour of item `index` of so many: names of their own for a few, else all round the circle of hues.
pub(crate) fn colour(index: usize, count: usize) -> String {
    if count <= COLOURS.len() {
        return COLOURS[index % COLOURS.len()].to_owned();
    }
    // By the golden angle, so that neighbours differ.
    format!("hsl({:.0},65%,40%)", (index as f64 * 137.508) % 360.0)
}

/// Without what XML gives a meaning to, or cannot hold.
fn escaped(text: &str) -> String {
    let plain: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    plain.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
