//! Every stock law on a graphics processor, beside the host.

use vesper::backend::Compiled;
use vesper::backend::gpu::{Comparison, Device, NotCompared, compare, wgsl_of};
use vesper::law::Shape;
use vesper::real::Scalar;
use vesper_laws::catalog::{StockLaw, stock_laws};

/// Rows of a comparison: more than one workgroup, and not whole ones.
const ROWS: usize = 1000;

/// The device that the system has; without one the test says so, and with `VESPER_REQUIRE_GPU=1` it fails.
fn device() -> Option<Device> {
    match Device::open() {
        Ok(device) => Some(device),
        Err(error) if std::env::var("VESPER_REQUIRE_GPU").is_ok_and(|required| required == "1") => {
            panic!("a device is required: {error}")
        }
        Err(error) => {
            eprintln!("not run: {error}");
            None
        }
    }
}

/// What a law is made of says how near its results must be.
#[derive(Debug, PartialEq)]
enum Kept {
    /// The same bits: nothing but what rounds in one way.
    Bits,
    /// Sums of many terms in another order, or functions that devices have in another way: parts of the largest number.
    Within(f64),
    /// Not on devices: its reason has these words.
    OnHost(&'static str),
}

/// What is expected of every stock law, by its name. A law that is not here fails the test.
fn kept(law: &StockLaw) -> Option<Kept> {
    Some(match law.signature.name {
        "damper"
        | "drag"
        | "electric_force"
        | "field_gravity"
        | "kinematics"
        | "magnetic_force"
        | "motion"
        | "quadratic_drag"
        | "quartic_spring"
        | "relativistic_mass"
        | "relativistic_motion"
        | "relativistic_velocity"
        | "rotating_frame"
        | "spring"
        | "uniform_gravity" => Kept::Bits,
        // Drivers may draw a factor out of a sum, or fuse a product with it: Mesa does so in these two, and rounds elsewhere.
        "contact_plane" | "henon_heiles" => Kept::Within(3e-7),
        // A cosine of the device's own.
        "driven_force" => Kept::Within(1e-6),
        // All pairs: sums of a thousand terms, in f32.
        "coulomb" | "einstein_infeld_hoffmann" | "gravity" | "gravity_by_parameter" | "newtonian_field" => {
            Kept::Within(1e-6)
        }
        "hierarchical_gravity" | "post_newtonian" => Kept::OnHost("whole columns"),
        _ => return None,
    })
}

/// The law with its parameters, and numbers that do something where those are 0.
fn compiled<P: Scalar>(law: &StockLaw) -> Compiled<P> {
    let parameters = law.default_parameters().into_iter().zip(1..);
    let parameters = parameters.map(|(value, at)| if value == 0.0 { 0.3 * f64::from(at) } else { value });
    law.compile(&parameters.collect::<Vec<f64>>())
}

fn compared<P: Scalar>(device: &Device, law: &StockLaw, rows: usize) -> Result<Comparison, NotCompared> {
    compare(device, &compiled::<P>(law), rows)
}

#[test]
fn every_stock_law_has_a_kernel_or_a_reason() {
    for law in stock_laws() {
        let compiled = compiled::<f32>(law);
        let name = law.signature.name;
        match (kept(law).unwrap_or_else(|| panic!("{name} is not in the list of this test")), wgsl_of(&compiled)) {
            (Kept::OnHost(words), Err(error)) => assert!(error.to_string().contains(words), "{error}"),
            (Kept::OnHost(_), Ok(_)) => panic!("{name} has a kernel now: say what is expected of it"),
            (_, Ok(text)) => assert!(text.contains("fn main"), "{text}"),
            (_, Err(error)) => panic!("{error}"),
        }
    }
}

#[test]
fn every_stock_law_gives_on_a_device_what_it_gives_on_the_host() {
    let Some(device) = device() else { return };
    println!("on {}", device.name());
    let mut wrong = Vec::new();
    for law in stock_laws() {
        let (name, kept) = (law.signature.name, kept(law));
        let Some(kept) = kept.filter(|kept| !matches!(kept, Kept::OnHost(_))) else { continue };
        let found = compared::<f32>(&device, law, ROWS).unwrap_or_else(|error| panic!("{error}"));
        let holds = match kept {
            Kept::Bits => found.same == found.numbers,
            Kept::Within(bound) => found.largest < bound,
            Kept::OnHost(_) => true,
        };
        let Comparison { numbers, same, zeros, largest } = found;
        println!("{name}: {same} of {numbers} numbers the same, {zeros} of them 0, largest difference {largest:.1e}");
        if !holds || 3 * zeros > 2 * numbers {
            wrong.push(format!("{name}: {found:?}, expected {kept:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn few_rows_are_no_special_case() {
    let Some(device) = device() else { return };
    for law in stock_laws().iter().filter(|law| kept(law) == Some(Kept::Bits)) {
        for rows in [0, 1, 2, 63, 64, 65] {
            let found = compared::<f32>(&device, law, rows).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(found.same, found.numbers, "{} of {rows} rows", law.signature.name);
        }
    }
}

/// Functions that devices do not have in f64 are refused; everything else gives the bits of the host, or nearly.
#[test]
fn f64_is_what_devices_have_of_it() {
    let Some(device) = device() else { return };
    for law in stock_laws().iter().filter(|law| !matches!(kept(law), Some(Kept::OnHost(_)))) {
        let name = law.signature.name;
        match compared::<f64>(&device, law, ROWS) {
            Ok(found) if compiled::<f64>(law).shape() == Shape::Pair => {
                assert!(found.largest < 1e-14, "{name}: {found:?}");
            }
            Ok(found) if matches!(name, "contact_plane" | "henon_heiles") => {
                assert!(found.largest < 6e-16, "{name}: {found:?}")
            }
            Ok(found) => assert_eq!(found.same, found.numbers, "{name}: {found:?}"),
            Err(NotCompared::NoKernel(error)) => {
                assert!(name == "driven_force" && error.to_string().contains("f64 has no `"), "{error}");
            }
            // The device has no f64 at all.
            Err(NotCompared::Device(error)) => assert!(error.to_string().contains("no f64"), "{error}"),
        }
    }
}
