//! Cases as files have them.

use serde_json::Value;

use crate::reader::Reader;

/// A problem with an answer that is known to more digits than numbers have.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Its name in reports.
    pub id: String,
    /// The speed of light, in the case's units, where motion is relativistic.
    pub light: Option<f64>,
    /// The bodies at the start.
    pub bodies: Vec<Body>,
    /// What moves them.
    pub laws: Vec<CaseLaw>,
    /// Time at the start.
    pub start: f64,
    /// States at later times, ascending.
    pub samples: Vec<Sample>,
    /// What errors of positions and of velocities are measured by; where the file does not say, the largest magnitudes in
    /// the samples.
    pub scale: [f64; 2],
    /// What no motion changes: "energy", "momentum", "angular_momentum", "jacobi" and others; where the file says it.
    pub conserved: Option<Vec<String>>,
}

/// A body at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Mass; at rest, where motion is relativistic.
    pub mass: f64,
    /// Charge.
    pub charge: f64,
    /// Whether it cannot move.
    pub fixed: bool,
    /// Position.
    pub position: [f64; 3],
    /// Velocity.
    pub velocity: [f64; 3],
}

/// The state at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// The time.
    pub time: f64,
    /// Positions of the bodies.
    pub position: Vec<[f64; 3]>,
    /// Velocities of the bodies.
    pub velocity: Vec<[f64; 3]>,
    /// By how much a relative error of the state at the start has grown, where the file says it.
    pub growth: Option<f64>,
}

/// Where a field is: from the first bounds up to, but not including, the second ones.
pub type Region = [[f64; 3]; 2];

/// A spring between two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// The numbers of the bodies.
    pub ends: [u32; 2],
    /// Stiffness.
    pub stiffness: f64,
    /// Damping along the axis.
    pub damping: f64,
    /// Length at rest.
    pub rest: f64,
}

/// A law of a case.
#[derive(Clone, Debug, PartialEq)]
pub enum CaseLaw {
    /// Every pair attracts: constant of gravitation, softening length.
    Gravity(f64, f64),
    /// Every pair of charges: Coulomb's constant.
    Coulomb(f64),
    /// Free fall.
    UniformGravity([f64; 3]),
    /// Centres that do not move: standard gravitational parameter, place.
    Attractors(Vec<(f64, [f64; 3])>),
    /// Angular velocity about z.
    RotatingFrame(f64),
    /// Linear and quadratic coefficient, wind.
    Drag(f64, f64, [f64; 3]),
    /// An electric field.
    Electric([f64; 3], Option<Region>),
    /// A magnetic field.
    Magnetic([f64; 3], Option<Region>),
    /// A magnetic bottle: field at the centre, length.
    Bottle(f64, f64),
    /// Hooke's springs.
    Springs(Vec<Spring>),
    /// Springs of the fourth power; `stiffness` is the factor of the power.
    QuarticSprings(Vec<Spring>),
    /// Body, amplitude, angular frequency, phase.
    Driven(u32, [f64; 3], [f64; 2]),
    /// The strength of the cubic part.
    HenonHeiles(f64),
    /// Normal, and offset, stiffness, damping, friction.
    Contact([f64; 3], [f64; 4]),
}

/// Reads the cases of a file: an object with `cases`, or a list of them.
///
/// # Errors
/// What is wrong with the text, and where.
pub fn read(text: &str) -> Result<Vec<Case>, String> {
    let value: Value = serde_json::from_str(text).map_err(|error| format!("it is no JSON: {error}"))?;
    let root = Reader::new(&value);
    root.optional("cases").unwrap_or(root).list(case)
}

fn case(reader: &Reader<'_>) -> Result<Case, String> {
    let dynamics = reader.field("dynamics")?;
    let light = match dynamics.field("type")?.text()?.as_str() {
        "newtonian" => None,
        "relativistic" => Some(dynamics.field("c")?.precise()?),
        _ => return dynamics.field("type")?.wrong("\"newtonian\" or \"relativistic\""),
    };
    let samples = reader.field("samples")?.list(sample)?;
    let largest = |of: fn(&Sample) -> &Vec<[f64; 3]>| {
        let length = |[x, y, z]: &[f64; 3]| (x * x + y * y + z * z).sqrt();
        samples.iter().flat_map(|sample| of(sample).iter().map(length)).fold(0.0, f64::max)
    };
    let scale = match reader.optional("scale") {
        Some(scale) => [scale.field("x")?.precise()?, scale.field("v")?.precise()?],
        None => [largest(|sample| &sample.position), largest(|sample| &sample.velocity)],
    };
    let bodies = reader.field("bodies")?.list(body)?;
    let count = bodies.len();
    if let Some(sample) = samples.iter().find(|sample| sample.position.len() != count || sample.velocity.len() != count)
    {
        return reader.wrong(&format!("{count} bodies in the sample at {:?}", sample.time));
    }
    let laws = reader.field("laws")?.list(law)?;
    let ends = |law: &CaseLaw| -> Vec<u32> {
        match law {
            CaseLaw::Springs(springs) | CaseLaw::QuarticSprings(springs) => {
                springs.iter().flat_map(|spring| spring.ends).collect()
            }
            CaseLaw::Driven(body, ..) => vec![*body],
            _ => Vec::new(),
        }
    };
    if let Some(body) = laws.iter().flat_map(ends).find(|body| *body as usize >= count) {
        return reader.field("laws")?.wrong(&format!("bodies 0 to {}, and not {body},", count.saturating_sub(1)));
    }
    Ok(Case {
        id: reader.field("id")?.text()?,
        light,
        bodies,
        laws,
        start: reader.optional("t0").map_or(Ok(0.0), |start| start.precise())?,
        samples,
        scale,
        conserved: reader.optional("conserved").map(|names| names.list(|name| name.text())).transpose()?,
    })
}

fn body(reader: &Reader<'_>) -> Result<Body, String> {
    Ok(Body {
        mass: reader.field("m")?.precise()?,
        charge: reader.optional("q").map_or(Ok(0.0), |charge| charge.precise())?,
        fixed: reader.optional("fixed").map_or(Ok(false), |fixed| fixed.flag())?,
        position: reader.field("x")?.vector()?,
        velocity: reader.field("v")?.vector()?,
    })
}

fn sample(reader: &Reader<'_>) -> Result<Sample, String> {
    Ok(Sample {
        time: reader.field("t")?.precise()?,
        position: reader.field("x")?.list(Reader::vector)?,
        velocity: reader.field("v")?.list(Reader::vector)?,
        growth: reader.optional("growth").map(|growth| growth.precise()).transpose()?,
    })
}

/// The types of laws that a case may have.
const LAWS: &str = "a law: newtonian_gravity, coulomb, uniform_gravity, fixed_attractors, rotating_frame, drag, \
                    electric_field, magnetic_field, magnetic_bottle, hooke_springs, quartic_springs, driven_force, \
                    henon_heiles or contact_plane";

fn law(reader: &Reader<'_>) -> Result<CaseLaw, String> {
    let number = |name: &str| reader.field(name)?.precise();
    let or_zero = |name: &str| reader.optional(name).map_or(Ok(0.0), |value| value.precise());
    let vector = |name: &str| reader.field(name)?.vector();
    let kind = reader.field("type")?;
    Ok(match kind.text()?.as_str() {
        "newtonian_gravity" => CaseLaw::Gravity(number("G")?, or_zero("softening")?),
        "coulomb" => CaseLaw::Coulomb(number("k_e")?),
        "uniform_gravity" => CaseLaw::UniformGravity(vector("g")?),
        "fixed_attractors" => {
            let center = |center: &Reader<'_>| Ok((center.field("gm")?.precise()?, center.field("x")?.vector()?));
            CaseLaw::Attractors(reader.field("centers")?.list(center)?)
        }
        "rotating_frame" => CaseLaw::RotatingFrame(number("omega_z")?),
        "drag" => {
            let wind = reader.optional("wind").map_or(Ok([0.0; 3]), |wind| wind.vector())?;
            CaseLaw::Drag(or_zero("b")?, or_zero("c")?, wind)
        }
        "electric_field" => CaseLaw::Electric(vector("E")?, region(reader)?),
        "magnetic_field" => CaseLaw::Magnetic(vector("B")?, region(reader)?),
        "magnetic_bottle" => CaseLaw::Bottle(number("B0")?, number("L")?),
        "hooke_springs" => CaseLaw::Springs(reader.field("springs")?.list(|one| spring(one, "k"))?),
        "quartic_springs" => CaseLaw::QuarticSprings(reader.field("springs")?.list(|one| spring(one, "kappa"))?),
        "driven_force" => {
            let swing = [number("omega")?, or_zero("phase")?];
            CaseLaw::Driven(reader.field("body")?.row()?, vector("F0")?, swing)
        }
        "henon_heiles" => CaseLaw::HenonHeiles(number("lambda")?),
        "contact_plane" => {
            CaseLaw::Contact(vector("normal")?, [or_zero("offset")?, number("k")?, or_zero("c")?, or_zero("mu")?])
        }
        _ => return kind.wrong(LAWS),
    })
}

fn spring(reader: &Reader<'_>, stiffness: &str) -> Result<Spring, String> {
    let or_zero = |name: &str| reader.optional(name).map_or(Ok(0.0), |value| value.precise());
    Ok(Spring {
        ends: [reader.field("i")?.row()?, reader.field("j")?.row()?],
        stiffness: reader.field(stiffness)?.precise()?,
        damping: or_zero("c")?,
        rest: or_zero("rest")?,
    })
}

/// `{ "x": [0, null], .. }`: null is no bound.
fn region(reader: &Reader<'_>) -> Result<Option<Region>, String> {
    let Some(region) = reader.optional("region") else { return Ok(None) };
    let mut bounds = [[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]];
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let Some(range) = region.optional(name) else { continue };
        let ends = range.list(|end| if end.value.is_null() { Ok(None) } else { end.precise().map(Some) })?;
        let [low, high] = ends[..] else { return range.wrong("two bounds") };
        bounds[0][axis] = low.unwrap_or(bounds[0][axis]);
        bounds[1][axis] = high.unwrap_or(bounds[1][axis]);
    }
    Ok(Some(bounds))
}
