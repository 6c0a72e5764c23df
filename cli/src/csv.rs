//! Tables of comma-separated values: a head line, `#` comments, numbers and names.
//!
//! In: text. Out: a [`Table`] whose columns are asked for by name. Never: quoted cells; a quote is a fault, for it would
//! hide commas. Written here because the `csv` crate (3 crates) gives neither comments with line numbers nor the places
//! of cells, and quoting is what it is good for.

use crate::fault::{SceneFault, help_for};

/// A table, its cells as text.
#[derive(Clone, Debug)]
pub struct Table {
    file: String,
    header: Vec<String>,
    rows: Vec<Row>,
}

#[derive(Clone, Debug)]
struct Row {
    line: usize,
    text: String,
    /// First byte and one past the last of each cell in `text`, blanks cut off.
    cells: Vec<(usize, usize)>,
}

impl Row {
    fn cell(&self, column: usize) -> &str {
        self.cells.get(column).map_or("", |&(start, end)| &self.text[start..end])
    }
}

impl Table {
    /// Reads `text`; `file` is its name in faults.
    pub fn parse(file: &str, text: &str) -> Result<Self, Vec<SceneFault>> {
        let mut table = Self { file: file.to_owned(), header: Vec::new(), rows: Vec::new() };
        let mut faults = Vec::new();
        let mut headed = false;
        for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
            if line.trim().is_empty() || line.trim_start().starts_with('#') {
                continue;
            }
            let row = Row { line: index + 1, text: line.to_owned(), cells: split(line) };
            if let Some(quote) = line.find('"') {
                let what = "a quote: cells stand without quotes, and hold no commas";
                faults.push(table.fault(&row, (quote, quote + 1), what));
            } else if headed && row.cells.len() != table.header.len() {
                let (n, of) = (row.cells.len(), table.header.len());
                faults.push(table.fault(&row, (0, line.len()), format!("this row has {n} cells, the head has {of}")));
            } else if headed {
                table.rows.push(row);
            } else {
                for column in 0..row.cells.len() {
                    let name = row.cell(column);
                    if name.is_empty() {
                        faults.push(table.fault(&row, row.cells[column], "a column without a name"));
                    } else if table.header.iter().any(|other| other == name) {
                        faults.push(table.fault(&row, row.cells[column], format!("two columns are named `{name}`")));
                    }
                    table.header.push(name.to_owned());
                }
            }
            // A head with a quote in it is still the head.
            if !headed && table.header.is_empty() {
                table.header = split(line).iter().map(|&(start, end)| line[start..end].replace('"', "")).collect();
            }
            headed = true;
        }
        if !headed {
            faults.push(SceneFault::of_file(file, "the table has no head line with the names of its columns"));
        }
        if faults.is_empty() { Ok(table) } else { Err(faults) }
    }

    /// Name of the file.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Names of the columns.
    pub fn header(&self) -> &[String] {
        &self.header
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    /// Place of the column `name`, or the words of the fault and its help, for whoever asked for it.
    pub fn find(&self, name: &str) -> Result<usize, (String, Option<String>)> {
        self.header.iter().position(|column| column == name).ok_or_else(|| {
            let help = help_for(name, self.header.iter().map(String::as_str));
            (format!("`{}` has no column `{name}`", self.file), help)
        })
    }

    /// The texts of a column, by its place.
    pub fn texts(&self, column: usize) -> Vec<&str> {
        self.rows.iter().map(|row| row.cell(column)).collect()
    }

    /// The numbers of a column, by its place; every cell that is none is a fault.
    pub fn numbers(&self, column: usize) -> Result<Vec<f64>, Vec<SceneFault>> {
        let name = self.header.get(column).map_or("", String::as_str);
        let mut faults = Vec::new();
        let mut numbers = Vec::with_capacity(self.rows.len());
        for row in &self.rows {
            let cell = row.cell(column);
            match cell.parse::<f64>() {
                Ok(number) if number.is_finite() => numbers.push(number),
                _ => {
                    let found = if cell.is_empty() { "nothing".to_owned() } else { format!("`{cell}`") };
                    let place = row.cells.get(column).copied().unwrap_or_default();
                    let text = format!("expected a number in column `{name}`, found {found}");
                    faults.push(self.fault(row, place, text));
                }
            }
        }
        if faults.is_empty() { Ok(numbers) } else { Err(faults) }
    }

    fn fault(&self, row: &Row, (start, end): (usize, usize), text: impl Into<String>) -> SceneFault {
        SceneFault {
            file: self.file.clone(),
            line: row.line,
            column: 1 + row.text[..start].chars().count(),
            source_line: row.text.clone(),
            span_len: row.text[start..end].chars().count().max(1),
            text: text.into(),
            help: None,
        }
    }
}

/// Where the cells of a line stand.
fn split(line: &str) -> Vec<(usize, usize)> {
    let mut start = 0;
    line.split(',')
        .map(|cell| {
            let lead = cell.len() - cell.trim_start().len();
            let first = start + lead;
            let place = (first, first + cell.trim().len());
            start += cell.len() + 1;
            place
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_blanks_and_signs() {
        let table =
            Table::parse("a.csv", "\u{feff}# by hand\n\nbody, x,y\r\n Sun , +1.5e0 ,-2\r\n# end\nMoon,3,4\n").unwrap();
        assert_eq!(table.header(), ["body", "x", "y"]);
        assert_eq!(table.texts(0), ["Sun", "Moon"]);
        assert_eq!(table.numbers(1).unwrap(), [1.5, 3.0]);
        assert_eq!(table.numbers(table.find("y").unwrap()).unwrap(), [-2.0, 4.0]);
        assert_eq!(table.find("bodi").unwrap_err().1.as_deref(), Some("did you mean `body`?"));
    }

    #[test]
    fn faults_with_line_and_column() {
        let faults = Table::parse("a.csv", "# c\nx,y,x\n1,2\n\"1\",2,3\n1,,3\n").unwrap_err();
        let shown: Vec<_> = faults.iter().map(|f| format!("{}:{}: {}", f.line, f.column, f.text)).collect();
        assert_eq!(
            shown,
            [
                "2:5: two columns are named `x`",
                "3:1: this row has 2 cells, the head has 3",
                "4:1: a quote: cells stand without quotes, and hold no commas",
            ]
        );
        let table = Table::parse("a.csv", "x,y\n1, é\nnan,\n").unwrap();
        let faults = [table.numbers(0).unwrap_err(), table.numbers(1).unwrap_err()].concat();
        let shown: Vec<_> = faults.iter().map(|f| format!("{}:{}: {}", f.line, f.column, f.text)).collect();
        assert_eq!(
            shown,
            [
                "3:1: expected a number in column `x`, found `nan`",
                "2:4: expected a number in column `y`, found `é`",
                "3:5: expected a number in column `y`, found nothing",
            ]
        );
    }

    #[test]
    fn a_table_without_a_head_is_a_fault() {
        assert_eq!(Table::parse("a.csv", "# only\n").unwrap_err().len(), 1);
    }
}
