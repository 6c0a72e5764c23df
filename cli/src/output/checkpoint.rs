//! Checkpoints as JSON.
//!
//! In: a [`Checkpoint`]. Out: text from which the same checkpoint is read, bit for bit. Never: a number that is not
//! finite; a run that broke leaves one from before.

use serde_json::{Value, json};
use vesper::engine::{ColumnData, DomainData, LawData};
use vesper::prelude::Checkpoint;

use crate::reader::Reader;

/// The format; another number is another one.
const VERSION: u64 = 6;

/// A checkpoint as JSON.
pub fn to_json(checkpoint: &Checkpoint) -> Value {
    let columns = |columns: &[ColumnData]| {
        let column = |column: &ColumnData| {
            json!({
                "property": column.property,
                "subset": column.subset,
                "numbers": column.numbers,
                "links": column.links,
            })
        };
        Value::Array(columns.iter().map(column).collect())
    };
    let domain = |domain: &DomainData| {
        json!({
            "name": domain.name,
            "rows": domain.rows,
            "columns": columns(&domain.columns),
            "previous": columns(&domain.previous),
        })
    };
    let law = |law: &LawData| {
        let memory: String = law.memory.iter().map(|byte| format!("{byte:02x}")).collect();
        json!({ "label": law.label, "declaration": law.declaration, "memory": memory })
    };
    let (time, since, step) = checkpoint.clock;
    json!({
        "vesper_checkpoint": VERSION,
        "precision": checkpoint.precision,
        "integrator": checkpoint.integrator,
        "time": checkpoint.time,
        "steps": checkpoint.steps,
        "remainder": checkpoint.remainder,
        "clock": { "time": time, "since": since, "step": step },
        "evaluations": checkpoint.evaluations,
        "origin": checkpoint.origin,
        "memory": checkpoint.memory,
        "domains": checkpoint.domains.iter().map(domain).collect::<Vec<_>>(),
        "laws": checkpoint.laws.iter().map(law).collect::<Vec<_>>(),
        "registers": checkpoint.registers,
        "held": checkpoint.held,
        "filled": checkpoint.filled,
    })
}

/// Reads a checkpoint.
///
/// # Errors
/// What is wrong with the text.
pub fn from_text(text: &str) -> Result<Checkpoint, String> {
    let value: Value = serde_json::from_str(text).map_err(|error| format!("it is no JSON: {error}"))?;
    let root = Reader::new(&value);
    if root.field("vesper_checkpoint").and_then(|version| version.count()) != Ok(VERSION) {
        return Err(format!("it is no checkpoint of version {VERSION}"));
    }
    let clock = root.field("clock")?;
    Ok(Checkpoint {
        precision: root.field("precision")?.text()?,
        integrator: root.field("integrator")?.text()?,
        time: root.field("time")?.number()?,
        steps: root.field("steps")?.count()?,
        remainder: root.field("remainder")?.number()?,
        clock: (clock.field("time")?.number()?, clock.field("since")?.count()?, clock.field("step")?.number()?),
        evaluations: root.field("evaluations")?.count()?,
        origin: root.field("origin")?.list(Reader::number)?,
        memory: root.field("memory")?.list(Reader::number)?,
        domains: root.field("domains")?.list(domain)?,
        laws: root.field("laws")?.list(law)?,
        registers: root.field("registers")?.list(|register| register.list(Reader::number))?,
        held: root.field("held")?.list(|held| held.list(|part| part.list(Reader::number)))?,
        filled: root.field("filled")?.list(Reader::flag)?,
    })
}

fn law(reader: &Reader<'_>) -> Result<LawData, String> {
    let memory = reader.field("memory")?;
    let digits = memory.text()?;
    let byte = |at: usize| digits.get(at..at + 2).and_then(|two| u8::from_str_radix(two, 16).ok());
    let bytes: Option<Vec<u8>> = (0..digits.len()).step_by(2).map(byte).collect();
    Ok(LawData {
        label: reader.field("label")?.text()?,
        declaration: reader.field("declaration")?.text()?,
        memory: bytes.map_or_else(|| memory.wrong("two hexadecimal digits for each byte"), Ok)?,
    })
}

fn domain(reader: &Reader<'_>) -> Result<DomainData, String> {
    let column = |reader: &Reader<'_>| {
        let subset = reader.field("subset")?;
        Ok(ColumnData {
            property: reader.field("property")?.text()?,
            subset: if subset.value.is_null() { None } else { Some(subset.list(Reader::row)?) },
            numbers: reader.field("numbers")?.list(Reader::number)?,
            links: reader.field("links")?.list(Reader::row)?,
        })
    };
    Ok(DomainData {
        name: reader.field("name")?.text()?,
        rows: usize::try_from(reader.field("rows")?.count()?).map_err(|error| error.to_string())?,
        columns: reader.field("columns")?.list(column)?,
        previous: reader.field("previous")?.list(column)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Checkpoint {
        let column = ColumnData {
            property: "position".to_owned(),
            subset: Some(vec![0, 4_000_000_000]),
            numbers: vec![0.1, -0.0, f64::MIN_POSITIVE / 3.0, 1e300, 1.0 / 3.0, f64::from(0.1_f32)],
            links: vec![7],
        };
        Checkpoint {
            precision: "f64".to_owned(),
            integrator: "leapfrog".to_owned(),
            time: 0.1 + 0.2,
            steps: 1 << 53,
            remainder: 1e-17,
            clock: (0.7, 3, 1e-3),
            evaluations: 12,
            origin: vec![1e7, -2e7, 0.1, 0.0, 1e-10, 0.0],
            memory: vec![1.0],
            domains: vec![DomainData {
                name: "a \"b\"".to_owned(),
                rows: 5,
                columns: vec![column.clone()],
                previous: vec![column],
            }],
            laws: vec![LawData {
                label: "a".to_owned(),
                declaration: "law a\nreads b".to_owned(),
                memory: vec![0, 9, 255],
            }],
            registers: vec![vec![1.5, 2.0 / 3.0], vec![]],
            held: vec![vec![vec![]]],
            filled: vec![true, false],
        }
    }

    #[test]
    fn reads_back_bit_for_bit() {
        let read = from_text(&to_json(&example()).to_string()).unwrap();
        assert_eq!(read, example());
        let bits = |of: &Checkpoint| of.domains[0].columns[0].numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&read), bits(&example()));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let text = to_json(&example()).to_string();
        let cases = [
            ("{", "it is no JSON"),
            ("{}", "it is no checkpoint of version 6"),
            (&text.replace("\"steps\":", "\"stps\":"), "expected `steps` at its root"),
            (&text.replace("\"filled\":[true", "\"filled\":[1"), "expected true or false at /filled/.."),
            (&text.replace("0009ff", "0009f"), "expected two hexadecimal digits for each byte at /laws/../memory"),
            (&text.replace("[[1.5,", "[[null,"), "expected a finite number at /registers/../.."),
        ];
        for (text, expected) in cases {
            let found = from_text(text).unwrap_err();
            assert!(found.starts_with(expected), "{found}");
        }
    }
}
