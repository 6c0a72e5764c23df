//! `vesper sweep`.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::atomic::Ordering;

use serde_json::json;

use super::arguments::Sweep;
use super::{Exit, bar, complain, say, stop_on_interrupt};
use crate::fault::SceneFault;
use crate::output::json;
use crate::sweep::ensemble::WHOLE;
use crate::sweep::folder::{PICTURE, TABLE};
use crate::sweep::work::{Ended, How, Known};
use crate::sweep::{Ensemble, Manifest, Measure, Plan, Record, Shard, SweepFolder, Vary, check, diagram, table, work};

/// More runs at the same time than this are a slip of the finger.
const MOST_JOBS: usize = 1024;
/// Pieces of a list of runs, for people.
const MOST_PIECES: usize = 10;

/// Records by the numbers of their runs.
type Records = BTreeMap<usize, Record>;

pub(super) fn sweep(arguments: &Sweep) -> Result<Exit, Vec<SceneFault>> {
    let Some(scene) = arguments.scene.as_deref() else { return of_a_folder(arguments) };
    let (plan, shard, jobs, limit) = planned(arguments, scene)?;
    let manifest = Manifest::new(&plan);
    let folder = arguments.out.as_deref().map(|out| SweepFolder::new(out, &manifest)).transpose()?;
    let ensemble = &plan.ensemble;
    if arguments.collect {
        return Ok(finish(arguments, ensemble, folder.as_ref(), Records::new(), shard));
    }
    let known = |run: usize| {
        let there = folder.as_ref().map_or(Ok(None), |folder| folder.record(ensemble, run));
        there.map(|record| record.filter(|record| record.fault.is_none() || !arguments.retry))
    };
    let (mut records, missing) = known_and_missing(shard.runs(ensemble.runs()), &known)?;
    let (how, mut trouble) = (How { jobs, limit, stop: stop_on_interrupt() }, None);
    let bar = bar(arguments.quiet, missing.len() as u64);
    work::make(&plan, &missing, &how, &known, |ended| {
        bar.inc(1);
        let kept = ended.and_then(|Ended { record, made }| {
            bar.set_message(ensemble.key(record.run));
            let kept = folder.as_ref().filter(|_| made).map_or(Ok(()), |folder| folder.keep(ensemble, &record));
            records.insert(record.run, record);
            kept
        });
        if let Err(text) = kept {
            // What cannot be kept need not be made.
            how.stop.store(true, Ordering::Relaxed);
            trouble.get_or_insert(text);
        }
    });
    bar.finish_and_clear();
    if let Some(text) = trouble {
        complain(&format!("error: {text}\n"));
        return Ok(Exit::Failed);
    }
    let of = shard.runs(ensemble.runs()).count();
    if records.len() < of {
        let on = match folder {
            Some(_) => "the same command goes on",
            None => "with --out DIR they would be kept, and the same command would go on",
        };
        let done = records.len();
        if folder.is_none() {
            // Nobody has them but this.
            let missing: Vec<usize> = (1..=of).filter(|run| !records.contains_key(run)).collect();
            let records: Vec<Record> = records.into_values().collect();
            say(&match (arguments.json, arguments.quiet || done == 0) {
                (true, _) => as_json(ensemble, &records, &missing),
                (false, true) => String::new(),
                (false, false) => table::words(ensemble, &records),
            });
        }
        complain(&format!("interrupted; {done} of {} are done; {on}\n", runs(of)));
        return Ok(Exit::Interrupted);
    }
    Ok(finish(arguments, ensemble, folder.as_ref(), records, shard))
}

/// Of some runs, the records that are known, and the others; or why that cannot be told.
fn known_and_missing(
    runs: impl Iterator<Item = usize>,
    known: &Known<'_>,
) -> Result<(Records, Vec<usize>), Vec<SceneFault>> {
    let (mut records, mut missing, mut faults) = (Records::new(), Vec::new(), Vec::new());
    for run in runs {
        match known(run) {
            Ok(Some(record)) => _ = records.insert(run, record),
            Ok(None) => missing.push(run),
            Err(text) => faults.push(SceneFault::of_file("--out", text)),
        }
        // A folder of which nothing can be read is told in fewer words than there are runs.
        if faults.len() == MOST_PIECES {
            break;
        }
    }
    if faults.is_empty() { Ok((records, missing)) } else { Err(faults) }
}

/// `--collect` without a scene: the folder says of what it is.
fn of_a_folder(arguments: &Sweep) -> Result<Exit, Vec<SceneFault>> {
    let more = !arguments.vary.is_empty() || !arguments.measure.is_empty() || !arguments.overrides().is_empty();
    let Some(out) = arguments.out.as_deref().filter(|_| !more) else {
        let text = "without a scene the folder says what was varied, measured and set: leave these options out";
        return Err(vec![SceneFault::of_file("--collect", text)]);
    };
    let (folder, manifest) = SweepFolder::open(out)?;
    Ok(finish(arguments, &manifest.ensemble, Some(&folder), Records::new(), WHOLE))
}

/// What is to be done, or everything that is wrong with it.
fn planned(arguments: &Sweep, scene: &Path) -> Result<(Plan, Shard, usize, Option<f64>), Vec<SceneFault>> {
    let mut faults = Vec::new();
    let (mut varies, mut measures) = (Vec::new(), Vec::new());
    for argument in &arguments.vary {
        match Vary::read(argument) {
            Ok(vary) => varies.push(vary),
            Err(more) => faults.extend(more),
        }
    }
    for argument in &arguments.measure {
        match Measure::read(argument) {
            Ok(measure) => measures.push(measure),
            Err(fault) => faults.push(fault),
        }
    }
    let shard = arguments.shard.as_deref().map_or(Ok(WHOLE), Shard::read).map_err(|fault| faults.push(fault));
    let jobs = jobs(arguments.jobs.as_deref()).map_err(|fault| faults.push(fault));
    let limit = arguments.limit.as_deref().map(limit).transpose().map_err(|fault| faults.push(fault));
    let ensemble = Ensemble { title: String::new(), varies, measures };
    let plan = Plan::new(scene, arguments.overrides(), arguments.settings.modules.modules(), ensemble)
        .map_err(|fault| faults.push(fault));
    match (plan, shard, jobs) {
        (Ok(mut plan), shard, jobs) => {
            check(&mut plan, faults)?;
            // Both are right, or check would have had their faults to give back.
            Ok((plan, shard.unwrap_or(WHOLE), jobs.unwrap_or(1), limit.unwrap_or(None)))
        }
        (Err(()), ..) => Err(faults),
    }
}

fn jobs(text: Option<&str>) -> Result<usize, SceneFault> {
    let Some(text) = text else { return Ok(std::thread::available_parallelism().map_or(1, usize::from)) };
    let wrong = |said: String| Err(SceneFault::of_argument("--jobs", text, text, said, None));
    match text.trim().parse() {
        Ok(jobs) if (1..=MOST_JOBS).contains(&jobs) => Ok(jobs),
        _ => wrong(format!("expected a whole number from 1 to {MOST_JOBS}, found `{}`", text.trim())),
    }
}

fn limit(text: &str) -> Result<f64, SceneFault> {
    let wrong = || SceneFault::of_argument("--limit", text, text, "expected a number above 0", None);
    text.trim().parse().ok().filter(|limit: &f64| *limit > 0.0 && limit.is_finite()).ok_or_else(wrong)
}

/// Adds to the records of a shard those of the folder, if all are there or all are asked for: a shard that is not the last one has
/// no business with those of others. Also which runs are missing.
fn gathered(
    arguments: &Sweep,
    ensemble: &Ensemble,
    folder: &SweepFolder,
    records: &mut Records,
) -> Result<Vec<usize>, String> {
    let listed = folder.listed()?;
    let mut missing: Vec<usize> = (1..=ensemble.runs()).filter(|run| !listed.contains(run)).collect();
    if missing.is_empty() || arguments.collect {
        for run in listed.range(1..=ensemble.runs()) {
            let Entry::Vacant(place) = records.entry(*run) else { continue };
            match folder.record(ensemble, *run)? {
                Some(record) => _ = place.insert(record),
                None => missing.push(*run),
            }
        }
        missing.sort_unstable();
    }
    Ok(missing)
}

/// Table and picture where all runs are there; else which are missing, and who makes them. `records`: those of the shard, by which
/// alone it has failed or not.
fn finish(
    arguments: &Sweep,
    ensemble: &Ensemble,
    folder: Option<&SweepFolder>,
    mut records: Records,
    shard: Shard,
) -> Exit {
    let own: BTreeSet<usize> = records.keys().copied().collect();
    let missing = match folder.map_or(Ok(Vec::new()), |folder| gathered(arguments, ensemble, folder, &mut records)) {
        Ok(missing) => missing,
        Err(trouble) => {
            complain(&format!("error: {trouble}\n"));
            return Exit::Failed;
        }
    };
    let records: Vec<Record> = records.into_values().collect();
    let mut text = String::new();
    if missing.is_empty() {
        text += &table::words(ensemble, &records);
        match folder.map(|folder| write(folder, ensemble, &records)) {
            Some(Err(trouble)) => {
                complain(&format!("error: {trouble}\n"));
                return Exit::Failed;
            }
            Some(Ok(files)) => text += &format!("\nwritten to {}: {}\n", shown(arguments), files.join(", ")),
            None => {}
        }
    } else {
        let (all, lacking) = (runs(ensemble.runs()), pieces(&missing));
        text += &format!(
            "{} of {all} are in {}; not there, or not yet: {lacking}\n",
            ensemble.runs() - missing.len(),
            shown(arguments)
        );
        text += &who(&missing, shard);
        text += &format!(
            "the last one to end makes the table, and so does vesper sweep --collect --out {}\n",
            shown(arguments)
        );
    }
    if arguments.json {
        text = as_json(ensemble, &records, &missing);
    }
    // A table that was asked for and is not there is a failure; of a shard that did its part it is the usual end.
    let lacks = arguments.collect && !missing.is_empty();
    let said = match (arguments.quiet && !arguments.json, lacks && !arguments.json) {
        (_, true) => {
            complain(&text);
            Exit::Done
        }
        (true, _) => Exit::Done,
        (false, _) => say(&text),
    };
    let own: Vec<Record> =
        records.into_iter().filter(|record| arguments.collect || own.contains(&record.run)).collect();
    let failed = own.iter().any(|record| record.fault.is_some());
    if failed {
        complain(&failures(ensemble, &own, missing.is_empty()));
    }
    if failed || lacks { Exit::Failed } else { said }
}

fn as_json(ensemble: &Ensemble, records: &[Record], missing: &[usize]) -> String {
    let runs: Vec<_> = records.iter().map(|record| record.to_json(ensemble)).collect();
    json::text(&json!({ "title": ensemble.title, "runs": runs, "missing": missing }))
}

/// How many runs failed; where no table says it, also which, and why.
fn failures(ensemble: &Ensemble, records: &[Record], in_a_table: bool) -> String {
    let failed: Vec<&Record> = records.iter().filter(|record| record.fault.is_some()).collect();
    let told = |record: &&Record| {
        format!("run {} ({}): {}\n", record.run, ensemble.key(record.run), record.fault.as_deref().unwrap_or_default())
    };
    let some: String = failed.iter().take(if in_a_table { 0 } else { MOST_PIECES }).map(told).collect();
    format!("{some}{} of {} failed\n", failed.len(), runs(records.len()))
}

/// Writes table and picture; their names.
fn write(folder: &SweepFolder, ensemble: &Ensemble, records: &[Record]) -> Result<Vec<&'static str>, String> {
    folder.write(TABLE, &table::csv(ensemble, records))?;
    let mut files = vec![TABLE];
    if let Some(picture) = diagram(ensemble, records) {
        folder.write(PICTURE, &picture)?;
        files.push(PICTURE);
    }
    Ok(files)
}

fn shown(arguments: &Sweep) -> String {
    arguments.out.as_deref().unwrap_or(Path::new("")).display().to_string()
}

fn runs(count: usize) -> String {
    crate::scene::plural(count, "run")
}

/// Who makes the missing runs.
fn who(missing: &[usize], shard: Shard) -> String {
    if shard == WHOLE {
        return "the same command as before makes them, in shards or without\n".to_owned();
    }
    let mut shards: Vec<usize> = missing.iter().map(|run| Shard::making(*run, shard.of)).collect();
    shards.sort_unstable();
    shards.dedup();
    let options: Vec<String> = shards.iter().take(MOST_PIECES).map(|k| format!("--shard {k}/{}", shard.of)).collect();
    let more = if shards.len() > MOST_PIECES { " and so on" } else { "" };
    format!("the same command makes them with {}{more}\n", options.join(", "))
}

/// Numbers of runs, as `2-4, 6`.
fn pieces(runs: &[usize]) -> String {
    let mut pieces: Vec<(usize, usize)> = Vec::new();
    for run in runs {
        match pieces.last_mut() {
            Some((_, last)) if *last + 1 == *run => *last = *run,
            _ => pieces.push((*run, *run)),
        }
    }
    let told =
        |(first, last): &(usize, usize)| if first == last { format!("{first}") } else { format!("{first}-{last}") };
    let words: Vec<String> = pieces.iter().take(MOST_PIECES).map(told).collect();
    format!("{}{}", words.join(", "), if pieces.len() > MOST_PIECES { " and so on" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_runs_are_told_in_few_words() {
        assert_eq!(pieces(&[2, 3, 4, 6, 8, 9]), "2-4, 6, 8-9");
        let odd: Vec<usize> = (1..100).step_by(2).collect();
        assert_eq!(pieces(&odd), "1, 3, 5, 7, 9, 11, 13, 15, 17, 19 and so on");
        let told = who(&[2, 4, 6], Shard { number: 1, of: 4 });
        assert!(told.contains("with --shard 2/4, --shard 4/4\n"), "{told}");
    }
}
