//! Rows that any stock law can run on: what it reads, in numbers without order. There is no answer to look up: crowds are for what
//! laws have in common, and for what they cost.

use crate::catalog::StockLaw;
use vesper::column::Values;
use vesper::law::{Mode, Place, Port};
use vesper::prelude::*;
use vesper::property::{PropertyInfo, Role};

/// Numbers without order in 0.5 to 1.5, the same every time, which f32 holds.
#[derive(Clone, Debug)]
pub struct Numbers(u64);

impl Numbers {
    /// The sequence of this seed.
    pub fn new(seed: u64) -> Self {
        Numbers(seed)
    }

    /// The next number.
    pub fn next_number(&mut self) -> f64 {
        // Knuth's linear congruential generator (MMIX), its upper bits.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 41) as f64 / (1_u64 << 23) as f64 + 0.5
    }

    /// A column of a property: vectors in all directions, numbers above 0.
    fn column<P: Precision>(&mut self, domain: Domain<P>, property: PropertyInfo, rows: usize) -> Domain<P> {
        let width = property.kind.width();
        let shift = if width == 1 { 0.0 } else { 1.0 };
        let numbers = (0..rows * width).map(|_| self.next_number() - shift).collect();
        domain.with(property, Values::new(width, numbers))
    }
}

/// The columns that a client gives so that a law runs: what it reads and rates, but not sums, which laws make.
fn given(port: &Port) -> bool {
    let computed = matches!(port.property.role, Role::Sum { .. }) || matches!(port.mode, Mode::Sets | Mode::Adds);
    matches!(port.place, Place::Own | Place::End) && !computed
}

/// Domains of so many rows with what the laws that stand on them touch; of laws over links, links between the rows of another domain,
/// two for each of its rows. Laws of one domain are listed side by side.
pub fn crowd<P: Precision>(laws: &[(&StockLaw, &str)], rows: usize) -> Vec<Domain<P>> {
    let mut numbers = Numbers::new(1);
    let mut names: Vec<&str> = laws.iter().map(|(_, domain)| *domain).collect();
    names.dedup();
    let mut made = Vec::new();
    for name in names {
        let mut properties: Vec<PropertyInfo> = vec![Position::INFO];
        let mut ends: Vec<PropertyInfo> = vec![Position::INFO];
        let mut link = None;
        for (law, _) in laws.iter().filter(|(_, domain)| *domain == name) {
            for port in law.signature.ports.iter().filter(|port| given(port)) {
                let to = if port.place == Place::End { &mut ends } else { &mut properties };
                if !to.iter().any(|known| known.name == port.property.name) {
                    to.push(port.property);
                }
            }
            link = link.or(law.signature.link);
        }
        // What a law of the same domain sets is not given.
        let on_domain = laws.iter().filter(|(_, domain)| *domain == name);
        let set: Vec<&str> = on_domain
            .flat_map(|(law, _)| law.signature.ports.iter())
            .filter(|port| port.mode == Mode::Sets)
            .map(|port| port.property.name)
            .collect();
        properties.retain(|property| !set.contains(&property.name));
        if let Some(link) = link {
            // Some rows are linked to several times, none in order.
            let mut end = || (((numbers.next_number() - 0.5) * rows as f64) as u32).min(rows as u32 - 1);
            let between: Vec<[u32; 2]> = (0..2 * rows).map(|_| [end(), end()]).collect();
            let linked = format!("{name}_ends");
            made.push(ends.iter().fold(Domain::new(&linked), |domain, info| numbers.column(domain, *info, rows)));
            let domain = Domain::new(name).link(link, &linked, between);
            properties.retain(|property| property.name != Position::NAME);
            made.push(properties.iter().fold(domain, |domain, info| numbers.column(domain, *info, 2 * rows)));
        } else {
            made.push(properties.iter().fold(Domain::new(name), |domain, info| numbers.column(domain, *info, rows)));
        }
    }
    made
}

/// The constants and fields that stock laws read.
pub fn surroundings<P: Precision>(builder: Builder<P>) -> Builder<P> {
    builder
        .constant(GravityAcceleration, [[0.125, 0.25, -9.8125]])
        .constant(SpeedOfLight, [20.0])
        .field(GravityField, |place: P::Vec3, time: P| place * time)
        .field(ElectricField, Point { at: [0.125, 0.25, 0.375], strength: 2.0 })
        .field(MagneticField, Uniform { value: [0.375, -0.25, 1.5] })
}

/// A number for every parameter of a law: its default, or 0.75.
pub fn parameters(law: &StockLaw) -> Vec<f64> {
    let declared = law.signature.parameters.iter();
    declared.flat_map(|parameter| parameter.default.unwrap_or([0.75; 3]).into_iter().take(parameter.width)).collect()
}

/// What a law of a domain moves or computes, each with the domain it is on; switches are the law's own.
pub fn results(law: &StockLaw, domain: &str) -> Vec<(String, PropertyInfo)> {
    let ports = law.signature.ports.iter().filter(|port| !port.mode.is_input() && port.property.role != Role::Switch);
    ports
        .map(|port| {
            let on = if port.place == Place::End { format!("{domain}_ends") } else { domain.to_owned() };
            (on, port.property)
        })
        .collect()
}
