//! What one part of a scene says about another: lengths, links, names of domains and laws.
//!
//! In: a scene that has been read and filled. Out: faults at the place of the mistake. Never: needs to know a property
//! or a law.

use super::Scene;
use super::domains::plural;
use super::walk::Walk;
use crate::fault::{Spanned, help_for};

/// A link column in which every row is wrong is not listed row by row.
const MOST_FAULTS_OF_A_LINK: usize = 10;

/// Checks `scene`, leaving out what depends on the domains in `incomplete`, or on laws unless `all_laws` could be read.
pub(crate) fn check(walk: &mut Walk, scene: &Scene, incomplete: &[String], all_laws: bool) {
    for domain in scene.domains.iter().filter(|domain| !incomplete.contains(&domain.name.value)) {
        lengths(walk, domain);
    }
    for domain in &scene.domains {
        for column in &domain.columns {
            let Some(link) = &column.link else { continue };
            known_domain(walk, scene, incomplete, link);
            let Some(target) = scene.domain(&link.value) else { continue };
            let Some(rows) = target.rows().filter(|_| !incomplete.contains(&link.value)) else { continue };
            let mut found = 0;
            for (index, row) in column.values.chunks(column.width.max(1)).enumerate() {
                let Some(bad) = row.iter().find(|&&row| row >= rows as f64) else { continue };
                let has = plural(rows, "row");
                walk.fault(
                    column.row_span(index),
                    format!("row {bad} does not exist: `{}` has {has}", link.value),
                    last(rows),
                );
                found += 1;
                if found == MOST_FAULTS_OF_A_LINK {
                    break;
                }
            }
        }
    }
    for law in &scene.laws {
        if let Some(domain) = &law.domain {
            known_domain(walk, scene, incomplete, domain);
        }
    }
    for column in scene.engine.observe.iter().flatten() {
        let Some((domain, _)) = column.value.split_once('.') else { continue };
        known_domain(walk, scene, incomplete, &Spanned::new(domain.to_owned(), column.span));
    }
    if let Some(compare) = &scene.compare {
        known_domain(walk, scene, incomplete, &compare.domain);
        for law in compare.without.iter().filter(|_| all_laws) {
            let known = || scene.laws.iter().flat_map(|law| [law.called(), law.name.value.as_str()]);
            if !known().any(|name| name == law.value) {
                let help = help_for(&law.value, known());
                walk.fault(law.span, format!("the scene has no law `{}`", law.value), help);
            }
        }
        if !incomplete.contains(&compare.domain.value) {
            labels(walk, scene);
        }
    }
}

/// Help for a row out of range.
fn last(rows: usize) -> Option<String> {
    rows.checked_sub(1).map(|last| format!("rows count from 0 to {last}"))
}

fn lengths(walk: &mut Walk, domain: &super::data::DomainData) {
    let Some(first) = domain.columns.iter().find(|column| column.subset.is_none()) else { return };
    for column in &domain.columns {
        match &column.subset {
            None if column.rows != first.rows => {
                let (n, other) = (plural(column.rows, "row"), &first.name.value);
                let text = format!("`{}` has {n}, `{other}` has {}", column.name.value, first.rows);
                walk.fault(column.name.span, text, None);
            }
            None => {}
            Some(subset) => {
                for row in subset.iter().filter(|row| row.value >= first.rows) {
                    let has = plural(first.rows, "row");
                    let text = format!("row {} does not exist: `{}` has {has}", row.value, domain.name.value);
                    walk.fault(row.span, text, last(first.rows));
                }
            }
        }
    }
    if let Some(labels) = domain.labels.as_ref().filter(|labels| labels.len() != first.rows) {
        let (n, other) = (plural(labels.len(), "row"), &first.name.value);
        walk.fault(domain.labels_span, format!("`name` has {n}, `{other}` has {}", first.rows), None);
    }
}

fn known_domain(walk: &mut Walk, scene: &Scene, incomplete: &[String], name: &Spanned<String>) {
    let known = || {
        let written = scene.domains.iter().map(|domain| domain.name.value.as_str());
        let generated = scene.generate.iter().map(|request| request.domain.value.as_str());
        written.chain(generated).chain(incomplete.iter().map(String::as_str)).chain(["scene"])
    };
    if !known().any(|known| known == name.value) {
        let help = help_for(&name.value, known());
        walk.fault(name.span, format!("the scene has no domain `{}`", name.value), help);
    }
}

/// Labels that `[compare]` names must be labels of rows.
fn labels(walk: &mut Walk, scene: &Scene) {
    let Some(compare) = &scene.compare else { return };
    let Some(domain) = scene.domain(&compare.domain.value) else { return };
    let Some(labels) = &domain.labels else {
        if domain.from.is_none() {
            let help = "add `name = [..]` to it, a label for each row".to_owned();
            walk.fault(compare.domain.span, format!("`{}` has no labels to compare by", domain.name.value), Some(help));
        }
        return;
    };
    let members = compare.barycentres.iter().flat_map(|(_, members)| members);
    for label in members.chain(compare.relative.iter().flat_map(|(_, pair)| pair)) {
        if !labels.contains(&label.value) {
            let help = help_for(&label.value, labels.iter().map(String::as_str));
            walk.fault(label.span, format!("`{}` has no row `{}`", domain.name.value, label.value), help);
        }
    }
}
