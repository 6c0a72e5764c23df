//! What a scene file says, as plain data.
//!
//! Every value that a later check can fault keeps its place. Nothing here knows laws, properties or integrators: names
//! are text, and values stay in the units in which they were written, except times of the engine, which are seconds.

use crate::fault::{Span, Spanned};

/// A number or vector with a name: a constant, a parameter of a law, an option of an integrator or a generator.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// The key.
    pub name: Spanned<String>,
    /// Its components, in `unit`: one for a number.
    pub value: Vec<f64>,
    /// Where the value stands.
    pub value_span: Span,
    /// The unit; none means the SI unit of the property or parameter.
    pub unit: Option<Spanned<String>>,
}

/// Number type of the state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32 bits.
    F32,
    /// 64 bits, the default.
    #[default]
    F64,
    /// Two times 53 bits.
    DoubleDouble,
}

/// The words of number types, in scenes and on the command line.
pub const PRECISIONS: [(&str, Precision); 3] =
    [("f32", Precision::F32), ("f64", Precision::F64), ("double-double", Precision::DoubleDouble)];

/// Where a law runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BackendChoice {
    /// By features and size, the default.
    #[default]
    Auto,
    /// One thread.
    Cpu,
    /// All threads.
    Parallel,
    /// Wherever a step takes least, by trying.
    Fastest,
    /// The graphics processor.
    Gpu,
}

/// The integrator by name, with its options (`rtol`, `atol`, or any number).
#[derive(Clone, Debug, PartialEq)]
pub struct IntegratorChoice {
    /// Its name, not checked here.
    pub name: Spanned<String>,
    /// Its options, not checked here.
    pub options: Vec<Parameter>,
}

/// Section `[engine]`; what is not written is `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EngineSettings {
    /// Number type.
    pub precision: Option<Spanned<Precision>>,
    /// The method.
    pub integrator: Option<IntegratorChoice>,
    /// Fixed step in s, above 0.
    pub step: Option<Spanned<f64>>,
    /// Length of a frame in s, above 0.
    pub frame: Option<Spanned<f64>>,
    /// Time to stop at in s, not negative.
    pub end: Option<Spanned<f64>>,
    /// Default backend of every law.
    pub backend: Option<Spanned<BackendChoice>>,
    /// Number of threads, at least 1.
    pub threads: Option<Spanned<usize>>,
    /// Whether a dormant law is an error.
    pub strict: Option<Spanned<bool>>,
    /// Whether rounding errors of the state are kept and added back.
    pub compensated: Option<Spanned<bool>>,
    /// Whether steps go across jumps of laws and fields.
    pub across_jumps: Option<Spanned<bool>>,
    /// Whether laws that allow estimates are computed with them.
    pub estimates: Option<Spanned<bool>>,
    /// Whether positions are kept relative to an origin that moves with the rows.
    pub moving_origin: Option<Spanned<bool>>,
    /// Columns to observe, as `domain.property`; `None` means every state property.
    pub observe: Option<Vec<Spanned<String>>>,
}

/// One box of a field: `min <= x < max` in each axis; bounds may be infinite.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldBox {
    /// Lower corner, inside.
    pub min: [f64; 3],
    /// Upper corner, outside.
    pub max: [f64; 3],
    /// The field inside: one component or three.
    pub value: Vec<f64>,
}

/// A stock shape of a field.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldShape {
    /// Constant inside boxes, 0 outside of all of them.
    Boxes(Vec<FieldBox>),
    /// The same everywhere: one component or three.
    Uniform(Vec<f64>),
    /// Around a point, falling as the inverse square: `strength (x - at) / |x - at|^3`.
    Point {
        /// The point.
        at: [f64; 3],
        /// Strength.
        strength: f64,
    },
    /// Around a dipole: `(3 (moment . u) u - moment) / r^3`.
    Dipole {
        /// The point.
        at: [f64; 3],
        /// Its moment.
        moment: [f64; 3],
    },
}

/// One field of section `[fields]`.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldData {
    /// Name of the field.
    pub name: Spanned<String>,
    /// Its shape.
    pub shape: FieldShape,
    /// Where the shape stands.
    pub shape_span: Span,
    /// Unit of its values.
    pub unit: Option<Spanned<String>>,
}

/// One column of a domain, from the scene, a CSV file, or a generator.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnData {
    /// The property.
    pub name: Spanned<String>,
    /// Components of a row: 1 for a number, 3 for a vector; 1 also where there are no rows, which then fit any width.
    pub width: usize,
    /// Number of values: of rows of the domain, or of rows of the subset.
    pub rows: usize,
    /// `rows * width` numbers, row by row, in `unit`. Rows of a link are whole, not negative, exact.
    pub values: Vec<f64>,
    /// For a subset, the rows that have a value, all different.
    pub subset: Option<Vec<Spanned<usize>>>,
    /// For a link, the domain whose rows it names.
    pub link: Option<Spanned<String>>,
    /// The unit; none means SI.
    pub unit: Option<Spanned<String>>,
    /// Where the column stands.
    pub span: Span,
    /// Where each row stands; empty for columns from files and generators.
    pub row_spans: Vec<Span>,
}

impl ColumnData {
    /// Where row `index` of this column stands, or else the column.
    pub fn row_span(&self, index: usize) -> Span {
        self.row_spans.get(index).copied().unwrap_or(self.span)
    }
}

/// A column that is read from a CSV file.
#[derive(Clone, Debug, PartialEq)]
pub struct CsvColumn {
    /// The property.
    pub property: Spanned<String>,
    /// The columns of the file that are its components.
    pub cells: Vec<Spanned<String>>,
    /// Its unit, from `units`.
    pub unit: Option<Spanned<String>>,
}

/// The `from` of a domain.
#[derive(Clone, Debug, PartialEq)]
pub struct FromCsv {
    /// The file, beside the scene.
    pub csv: Spanned<String>,
    /// What it fills.
    pub columns: Vec<CsvColumn>,
    /// The column with the labels of the rows (`name`).
    pub label: Option<Spanned<String>>,
}

/// One domain.
#[derive(Clone, Debug, PartialEq)]
pub struct DomainData {
    /// Its name; for a domain that only a generator fills, the place of the generator.
    pub name: Spanned<String>,
    /// Its columns: as written, then from the CSV file, then generated.
    pub columns: Vec<ColumnData>,
    /// Labels of the rows (`name`), written or from the file.
    pub labels: Option<Vec<String>>,
    /// Where the labels stand.
    pub labels_span: Span,
    /// The CSV file it was filled from.
    pub from: Option<FromCsv>,
}

impl DomainData {
    /// A domain without columns.
    pub fn new(name: Spanned<String>) -> Self {
        Self { name, columns: Vec::new(), labels: None, labels_span: Span::default(), from: None }
    }

    /// Number of rows, where a full column or the labels tell it.
    pub fn rows(&self) -> Option<usize> {
        let full = self.columns.iter().find(|column| column.subset.is_none());
        full.map(|column| column.rows).or(self.labels.as_ref().map(Vec::len))
    }

    /// The column of the property `name`.
    pub fn column(&self, name: &str) -> Option<&ColumnData> {
        self.columns.iter().find(|column| column.name.value == name)
    }
}

/// One `[generate.DOMAIN]`.
#[derive(Clone, Debug, PartialEq)]
pub struct GenerateRequest {
    /// The domain for the masses.
    pub domain: Spanned<String>,
    /// Which generator.
    pub kind: Spanned<String>,
    /// All other keys, `count` and `seed` among them.
    pub options: Vec<Parameter>,
}

/// One `[[laws]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct LawRequest {
    /// Name of the law, not checked here.
    pub name: Spanned<String>,
    /// The module that it is in; none for a stock law.
    pub module: Option<Spanned<String>>,
    /// What the law's declaration was when the scene was written, as a number.
    pub fingerprint: Option<Spanned<String>>,
    /// The domain to stand on, where there is a choice.
    pub domain: Option<Spanned<String>>,
    /// A name of its own, where a law stands twice.
    pub label: Option<Spanned<String>>,
    /// Its parameters, not checked here.
    pub parameters: Vec<Parameter>,
    /// Where it runs.
    pub backend: Option<Spanned<BackendChoice>>,
    /// Evaluate on every k-th step, at least 1.
    pub every: Option<Spanned<usize>>,
    /// The error that far rows may be summed together with.
    pub far_field: Option<f64>,
    /// Whether it is switched on; default true.
    pub enabled: bool,
    /// Where the entry begins.
    pub span: Span,
}

impl LawRequest {
    /// The label, or else the name.
    pub fn called(&self) -> &str {
        self.label.as_ref().map_or(&self.name.value, |label| &label.value)
    }
}

/// The time column of a table of reference positions.
#[derive(Clone, Debug, PartialEq)]
pub struct CompareTime {
    /// Column of the file.
    pub column: Spanned<String>,
    /// Its unit; none means seconds.
    pub unit: Option<Spanned<String>>,
    /// What the column says at the start of the scene, in `unit`; default 0.
    pub origin: f64,
}

/// Section `[compare]`: positions known from elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Compare {
    /// The file, beside the scene.
    pub csv: Spanned<String>,
    /// Its time.
    pub time: CompareTime,
    /// The three columns of the position.
    pub position: Vec<Spanned<String>>,
    /// Their unit; none means metres.
    pub unit: Option<Spanned<String>>,
    /// The column that says which row of the domain is meant, by its label.
    pub name: Spanned<String>,
    /// The domain that is compared.
    pub domain: Spanned<String>,
    /// Laws (by name or label) to leave out in a second run.
    pub without: Vec<Spanned<String>>,
    /// Names in the file that mean the centre of mass of several rows: the name, the labels of the rows.
    pub barycentres: Vec<(Spanned<String>, Vec<Spanned<String>>)>,
    /// Names in the file that mean the first row's position seen from the second: the name, the two labels.
    pub relative: Vec<(Spanned<String>, [Spanned<String>; 2])>,
}
