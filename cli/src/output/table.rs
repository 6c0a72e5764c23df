//! The shown columns of a domain over time, as comma-separated values.
//!
//! In: columns at moments. Out: a line for each row and moment: time, row, label, components, in SI; numbers read back to
//! the same bits. Never: a moment twice.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::run::snapshot::ShownDomain;

/// A table that is being written.
#[derive(Debug)]
pub struct Table {
    file: BufWriter<File>,
    labels: Vec<String>,
}

impl Table {
    /// Begins a table at `path` for the columns of `domain`, whose rows have these labels.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn new(path: &Path, domain: &ShownDomain, labels: &[String]) -> io::Result<Self> {
        let mut file = BufWriter::new(File::create(path)?);
        let mut head = "time,row,label".to_owned();
        for column in &domain.columns {
            let name = column.property.name;
            match column.width() {
                1 => head += &format!(",{}", cell(name)),
                width => {
                    for part in 0..width {
                        let part = if width == 3 || width == 4 {
                            ["x", "y", "z", "w"][part].to_owned()
                        } else {
                            part.to_string()
                        };
                        head += &format!(",{}", cell(&format!("{name}_{part}")));
                    }
                }
            }
        }
        writeln!(file, "{head}")?;
        Ok(Self { file, labels: labels.iter().map(|label| cell(label)).collect() })
    }

    /// Adds a moment.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, time: f64, domain: &ShownDomain) -> io::Result<()> {
        for row in 0..domain.rows {
            write!(self.file, "{time:?},{row},{}", self.labels.get(row).map_or("", String::as_str))?;
            for column in &domain.columns {
                match column.row(row) {
                    Some(numbers) => numbers.iter().try_for_each(|number| write!(self.file, ",{number:?}"))?,
                    None => (0..column.width()).try_for_each(|_| write!(self.file, ","))?,
                }
            }
            writeln!(self.file)?;
        }
        Ok(())
    }

    /// Ends the table.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// A text as a cell: in quotes where it holds what would end the cell.
pub(crate) fn cell(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}
