//! What each stock law costs: every law of the catalog by its size, backend and precision, with the error of what it gives.
//!
//! A law alone on a crowd of rows without order: one frame of one step, in which it is evaluated once, and what moves is moved. The
//! time is that of a row, of an ordered pair, or of a link, of which there are two for each row. Two threads are used whatever the
//! size, where `Backend::Auto` would leave small crowds to one. The error is the root mean square of |a - a_ref| / |a_ref| over the rows,
//! the largest one of all properties that the law gives, beside the same frame in numbers of twice the digits of f64; what rows begin
//! with is held by f32, but for parameters of laws that are not.

use vesper::law::Shape;
use vesper::prelude::*;
use vesper::property::PropertyInfo;
use vesper::registry::Options;
use vesper_benches::scenes::STEP;
use vesper_benches::{Case, Contender, Race, Run, Summary, Time};
use vesper_laws::catalog::{CatalogPrecision, StockLaw, stock_laws};
use vesper_laws::reference::crowd::{crowd, parameters, results, surroundings};

const DOMAIN: &str = "rows";
const STAYS: &str = "the rows stay finite";

fn shape(law: &StockLaw) -> Shape {
    law.compile::<f64>(&parameters(law)).shape()
}

/// Rows of the crowds for laws of a shape.
fn sizes(shape: Shape) -> [usize; 2] {
    match shape {
        Shape::Row => [1000, 300_000],
        Shape::Pair => [1000, 4000],
        Shape::Link => [1000, 100_000],
        Shape::Column => [10, 1000],
    }
}

/// What is counted: how many there are, and a word for one.
fn units(shape: Shape, rows: usize) -> (usize, &'static str) {
    match shape {
        Shape::Row | Shape::Column => (rows, "ns/row"),
        Shape::Pair => (rows * (rows - 1), "ns/pair"),
        Shape::Link => (2 * rows, "ns/link"),
    }
}

fn engine<P: CatalogPrecision>(law: &StockLaw, rows: usize, threads: usize) -> Engine<P> {
    let builder = surroundings(Engine::<P>::builder()).integrator(SemiImplicitEuler).step(STEP);
    let builder = builder.backend(if threads == 1 { Backend::Cpu } else { Backend::Parallel }).threads(threads);
    let builder = crowd(&[(law, DOMAIN)], rows).into_iter().fold(builder, Builder::domain);
    let options = Options { domain: Some(DOMAIN.to_owned()), ..Options::default() };
    let builder = builder.listed(law.compile(&parameters(law)), options);
    let observe = |builder: Builder<P>, (domain, property): &(String, PropertyInfo)| builder.observe(domain, *property);
    results(law, DOMAIN).iter().fold(builder, observe).build().expect("the crowd has all that the law reads")
}

/// What a law gives in its first frame, property by property.
fn given<P: CatalogPrecision>(law: &StockLaw, engine: &mut Engine<P>) -> Vec<Vec<f64>> {
    engine.steps_of(1, STEP).expect(STAYS);
    let numbers = |(domain, property): &(String, PropertyInfo)| engine.state().numbers(domain, *property);
    results(law, DOMAIN).iter().map(|result| numbers(result).expect("the engine has what laws give")).collect()
}

/// The root mean square of the rows' errors, each in parts of the row's own number or vector; of the property where it is largest.
fn difference(law: &StockLaw, found: &[Vec<f64>], exact: &[Vec<f64>]) -> f64 {
    let widths = results(law, DOMAIN).into_iter().map(|(_, property)| property.kind.width());
    let errors = widths.zip(found).zip(exact).map(|((width, found), exact)| {
        let size = |numbers: &[f64]| numbers.iter().map(|x| x * x).sum::<f64>();
        let (mut squares, mut rows) = (0.0, 0.0);
        for (found, exact) in found.chunks_exact(width).zip(exact.chunks_exact(width)) {
            let off: Vec<f64> = found.iter().zip(exact).map(|(a, b)| a - b).collect();
            assert!(off.iter().all(|off| off.is_finite()), "{}: {found:?}", law.signature.name);
            if size(exact) > 0.0 {
                squares += size(&off) / size(exact);
                rows += 1.0;
            } else {
                assert_eq!(size(&off), 0.0, "{}: what is 0", law.signature.name);
            }
        }
        assert!(rows > 0.0, "{} gives nothing", law.signature.name);
        (squares / rows).sqrt()
    });
    errors.fold(0.0, f64::max)
}

/// One law on one crowd: on one thread and on two, in both precisions.
fn study(law: &StockLaw, rows: usize, run: Run, summary: &mut Summary) {
    let exact = given(law, &mut engine::<DoubleDouble>(law, rows, 2));
    let (mut contenders, mut cases) = (Vec::new(), Vec::new());
    for threads in [1, 2] {
        for precision in [f32::NAME, f64::NAME] {
            let (contender, error) = if precision == f32::NAME {
                frame(engine::<f32>(law, rows, threads), law, &exact)
            } else {
                frame(engine::<f64>(law, rows, threads), law, &exact)
            };
            contenders.push(contender);
            cases.push((threads, precision, error));
        }
    }
    let (units, unit) = units(shape(law), rows);
    let race = Race { rounds: 21, ..Race::default() };
    let times = race.run(run, units as f64, &mut contenders);
    let named = |time: &Time| (Time { name: "one thread", ..*time }, None);
    let ones: Vec<_> = times[..2].iter().map(named).collect();
    for (number, ((threads, precision, error), time)) in cases.into_iter().zip(&times).enumerate() {
        let case = Case { name: law.signature.name, n: rows, threads, precision, unit, error: Some(error) };
        summary.add(case, *time, if threads == 1 { &[] } else { &ones[number - 2..number - 1] });
    }
}

/// Frames of an engine, and the error of the first one.
fn frame<'a, P: CatalogPrecision>(mut engine: Engine<P>, law: &StockLaw, exact: &[Vec<f64>]) -> (Contender<'a>, f64) {
    let error = difference(law, &given(law, &mut engine), exact);
    assert!(error < 1e4 * P::EPSILON, "{}: an error of {error:e}", law.signature.name);
    (Contender::new("frame", move || engine.steps_of(1, STEP).expect(STAYS)), error)
}

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let mut summary = Summary::new("laws", run);
    for law in stock_laws() {
        let sizes = sizes(shape(law));
        for rows in if run == Run::Test { &sizes[..1] } else { &sizes[..] } {
            if run.wants(&format!("laws/{}/{rows}", law.signature.name)) {
                study(law, *rows, run, &mut summary);
            }
        }
    }
    summary.write()
}
