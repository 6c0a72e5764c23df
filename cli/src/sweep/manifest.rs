//! Whose a folder is: all that the results of a sweep depend on.
//!
//! In: a plan. Out: JSON from which the same ensemble is read; what makes two sweeps different, in words. Never: a path of the
//! machine, a number of threads or of shards: results do not depend on them.
//!
//! The scene stands there as its whole text, so that a folder says by itself what it is, and of another scene the first line
//! that differs can be shown. Of files beside the scene and of libraries with laws there is a hash.

use serde_json::{Value, json};

use super::ensemble::Ensemble;
use super::measure::Measure;
use super::plan::Plan;
use super::vary::{Spacing, Vary};
use crate::reader::Reader;
use crate::scene::Override;

/// The format; another number is another one.
const VERSION: u64 = 2;

/// All that results depend on.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifest {
    /// The version of the command: another one may round elsewhere.
    pub vesper: String,
    /// The text of the scene.
    pub scene: String,
    /// Changes of it, as they were written.
    pub changes: Vec<String>,
    /// Files that the scene reads in any run, each with a hash of its bytes.
    pub files: Vec<(String, String)>,
    /// Modules of laws that it names in any run, each with a hash of its library.
    pub modules: Vec<(String, String)>,
    /// The runs.
    pub ensemble: Ensemble,
}

impl Manifest {
    /// Of a plan that has been checked.
    pub fn new(plan: &Plan) -> Self {
        let told = |change: &Override| change.source().0;
        let matters = |change: &&Override| !matches!(change, Override::Engine { key: "threads", .. });
        Self {
            vesper: env!("CARGO_PKG_VERSION").to_owned(),
            scene: plan.text.clone(),
            changes: plan.changes.iter().filter(matters).map(told).collect(),
            files: plan.files.account(),
            modules: plan.libraries.clone().into_iter().collect(),
            ensemble: plan.ensemble.clone(),
        }
    }

    /// As JSON.
    pub fn to_json(&self) -> Value {
        let vary = |vary: &Vary| json!({ "path": vary.path, "spacing": vary.spacing.name(), "values": vary.values });
        let measure = |measure: &Measure| json!({ "measure": measure.text, "unit": measure.unit });
        let hashed = |what: &str, list: &[(String, String)]| -> Vec<Value> {
            list.iter().map(|(name, hash)| json!({ what: name, "fnv1a": hash })).collect()
        };
        let Ensemble { title, varies, measures } = &self.ensemble;
        json!({
            "vesper_sweep": VERSION,
            "vesper": self.vesper,
            "title": title,
            "runs": self.ensemble.runs(),
            "vary": varies.iter().map(vary).collect::<Vec<_>>(),
            "measures": measures.iter().map(measure).collect::<Vec<_>>(),
            "changes": self.changes,
            "files": hashed("file", &self.files),
            "modules": hashed("module", &self.modules),
            "scene": self.scene,
        })
    }

    /// Reads one.
    ///
    /// # Errors
    /// What is wrong with the text.
    pub fn read(text: &str) -> Result<Self, String> {
        let value: Value = serde_json::from_str(text).map_err(|error| format!("it is no JSON: {error}"))?;
        let root = Reader::new(&value);
        if root.field("vesper_sweep").and_then(|version| version.count()) != Ok(VERSION) {
            return Err(format!("it is no manifest of version {VERSION}"));
        }
        let vary = |vary: &Reader<'_>| {
            let name = vary.field("spacing")?.text()?;
            let spacing = Spacing::NAMES.iter().find(|(known, _)| *known == name);
            let values = vary.field("values")?.list(Reader::text)?;
            match spacing {
                Some((_, spacing)) if !values.is_empty() => {
                    Ok(Vary { path: vary.field("path")?.text()?, values, spacing: *spacing })
                }
                _ => vary.wrong("a spacing, and at least one value"),
            }
        };
        let measure = |measure: &Reader<'_>| {
            let read = Measure::read(&measure.field("measure")?.text()?).map_err(|fault| fault.text)?;
            Ok(Measure { unit: measure.field("unit")?.text()?, ..read })
        };
        let hashed = |what: &str| {
            let pair = |one: &Reader<'_>| Ok((one.field(what)?.text()?, one.field("fnv1a")?.text()?));
            root.field(&format!("{what}s"))?.list(pair)
        };
        let ensemble = Ensemble {
            title: root.field("title")?.text()?,
            varies: root.field("vary")?.list(vary)?,
            measures: root.field("measures")?.list(measure)?,
        };
        if ensemble.checked_runs().is_none_or(|runs| runs > super::ensemble::MOST_RUNS) {
            return root.wrong("fewer runs");
        }
        Ok(Self {
            vesper: root.field("vesper")?.text()?,
            scene: root.field("scene")?.text()?,
            changes: root.field("changes")?.list(Reader::text)?,
            files: hashed("file")?,
            modules: hashed("module")?,
            ensemble,
        })
    }

    /// What makes a sweep another one than this: nothing where they are the same.
    pub fn differences(&self, other: &Manifest) -> Vec<String> {
        let mut found = Vec::new();
        let mut note = |what: &str, here: String, there: String| {
            if here != there {
                found.push(format!("{what}: in the folder {}, now {}", quoted(&here), quoted(&there)));
            }
        };
        note("the version of vesper", self.vesper.clone(), other.vesper.clone());
        if self.scene != other.scene {
            let (mut here, mut there) = (self.scene.lines(), other.scene.lines());
            let mut line = 1;
            loop {
                match (here.next(), there.next()) {
                    (None, None) => break note("the scene", "other line ends".to_owned(), "these".to_owned()),
                    (a, b) if a == b => line += 1,
                    (a, b) => {
                        let [a, b] = [a, b].map(|text| text.unwrap_or_default().to_owned());
                        break note(&format!("line {line} of the scene"), a, b);
                    }
                }
            }
        }
        note("changes of the scene", self.changes.join(" "), other.changes.join(" "));
        let hashed = |list: &[(String, String)]| -> String {
            list.iter().map(|(name, hash)| format!("{name} ({hash})")).collect::<Vec<_>>().join(", ")
        };
        note("files beside the scene", hashed(&self.files), hashed(&other.files));
        note("modules of laws", hashed(&self.modules), hashed(&other.modules));
        let varies = |of: &Manifest| -> String {
            let told = |vary: &Vary| format!("{}=[{}]", vary.path, vary.values.join(", "));
            of.ensemble.varies.iter().map(told).collect::<Vec<_>>().join(" ")
        };
        note("what varies", varies(self), varies(other));
        let measures = |of: &Manifest| -> String {
            of.ensemble.measures.iter().map(|measure| measure.text.clone()).collect::<Vec<_>>().join(" ")
        };
        note("what is measured", measures(self), measures(other));
        found
    }
}

/// A text in quotes, cut where it is long; a word for none.
fn quoted(text: &str) -> String {
    const WIDEST: usize = 120;
    match text.trim() {
        "" => "nothing".to_owned(),
        text if text.chars().count() > WIDEST => format!("`{}..`", text.chars().take(WIDEST).collect::<String>()),
        text => format!("`{text}`"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Manifest {
        let measures = vec![Measure { unit: "m".to_owned(), ..Measure::read("bodies.position[0].x").unwrap() }];
        let varies = vec![Vary::read("a.b=1:100:3:log").unwrap(), Vary::read("c=[x, y]").unwrap()];
        Manifest {
            vesper: "0.1.0".to_owned(),
            scene: "[engine]\nstep = 1\n".to_owned(),
            changes: vec!["--end 5".to_owned()],
            files: vec![("a.csv".to_owned(), "af63dc4c8601ec8c".to_owned())],
            modules: vec![("lift".to_owned(), "af63dc4c8601ec8d".to_owned())],
            ensemble: Ensemble { title: "t".to_owned(), varies, measures },
        }
    }

    #[test]
    fn reads_back_and_knows_itself() {
        let one = example();
        let read = Manifest::read(&one.to_json().to_string()).unwrap();
        assert_eq!(read, one);
        assert!(one.differences(&read).is_empty());
    }

    #[test]
    fn what_differs_is_said() {
        let one = example();
        let mut other = example();
        other.scene = "[engine]\nstep = 2\n".to_owned();
        other.changes.clear();
        other.ensemble.varies.pop();
        assert_eq!(
            one.differences(&other),
            [
                "line 2 of the scene: in the folder `step = 1`, now `step = 2`",
                "changes of the scene: in the folder `--end 5`, now nothing",
                "what varies: in the folder `a.b=[1, 10, 100] c=[x, y]`, now `a.b=[1, 10, 100]`",
            ]
        );
    }

    #[test]
    fn what_is_wrong_is_said() {
        let text = example().to_json().to_string();
        let none = text.replace("[\"x\",\"y\"]", "[]");
        for (text, expected) in [
            ("{", "it is no JSON"),
            ("{}", "it is no manifest of version 2"),
            (none.as_str(), "expected a spacing, and at least one value at /vary/.."),
        ] {
            let told = Manifest::read(text).unwrap_err();
            assert!(told.starts_with(expected), "{told}");
        }
    }
}
