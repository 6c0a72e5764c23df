//! A case as domains and laws, and an engine's distance from its answer.

use vesper::prelude::*;
use vesper_laws::{
    ContactPlane, Coulomb, Damper, Drag, DrivenForce, DrivingAmplitude, ElectricForce, FieldGravity, Gravity,
    HenonHeiles, MagneticForce, Motion, QuadraticDrag, QuarticSpring, QuarticStiffness, RelativisticMotion,
    RelativisticVelocity, RotatingFrame, Spring as HookeSpring, UniformGravity,
};

use super::case::{Body, Case, CaseLaw, Region, Spring};

const BODIES: &str = "bodies";

/// A builder with the case's domains, constants, fields and laws; the integrator is the caller's.
pub fn builder<P: Precision>(case: &Case) -> Builder<P> {
    let builder = Engine::builder().constant(Time, [case.start]);
    let (builder, bodies) = motion(case, builder);
    let parts = case.laws.iter().fold(Parts { builder, bodies, ..Parts::new() }, |parts, law| parts.law(law, case));
    parts.finish(case)
}

/// The rows, and the law that moves them.
fn motion<P: Precision>(case: &Case, builder: Builder<P>) -> (Builder<P>, Domain<P>) {
    let all = |of: fn(&Body) -> [f64; 3]| case.bodies.iter().map(of).collect::<Vec<_>>();
    let velocity = |body: &Body| if body.fixed { [0.0; 3] } else { body.velocity };
    // Mass 0 is immovable.
    let mass: Vec<f64> = case.bodies.iter().map(|body| if body.fixed { 0.0 } else { body.mass }).collect();
    let bodies = Domain::new(BODIES).with(Position, all(|body| body.position));
    match case.light {
        None => {
            let bodies = bodies.with(Velocity, case.bodies.iter().map(velocity).collect::<Vec<_>>()).with(Mass, mass);
            (builder.law(Motion), bodies)
        }
        Some(light) => {
            let momentum = |body: &Body| {
                let velocity = DVec3::from_array(velocity(body));
                let gamma = 1.0 / (1.0 - velocity.length_squared() / (light * light)).sqrt();
                (velocity * (gamma * body.mass)).to_array()
            };
            let momenta: Vec<[f64; 3]> = case.bodies.iter().map(momentum).collect();
            let bodies = bodies.with(Momentum, momenta).with(RestMass, mass);
            (builder.constant(SpeedOfLight, [light]).law(RelativisticMotion), bodies)
        }
    }
}

/// What the laws of a case add to a builder, while they are gone through.
struct Parts<P: Precision> {
    builder: Builder<P>,
    bodies: Domain<P>,
    pull: Points,
    electric: Boxes,
    magnetic: Boxes,
    bottle: bool,
}

impl<P: Precision> Parts<P> {
    fn new() -> Self {
        Parts {
            builder: Engine::builder(),
            bodies: Domain::new(BODIES),
            pull: Points::default(),
            electric: Boxes::default(),
            magnetic: Boxes::default(),
            bottle: false,
        }
    }

    fn with_law(self, law: impl Listing) -> Self {
        Parts { builder: self.builder.law(law), ..self }
    }

    fn law(mut self, law: &CaseLaw, case: &Case) -> Self {
        let rows = case.bodies.len();
        match law {
            CaseLaw::Gravity(g, softening) => {
                // What cannot move has mass 0, and attracts all the same.
                let fixed = case.bodies.iter().filter(|body| body.fixed);
                self.pull.points.extend(fixed.map(|body| Point { at: body.position, strength: -g * body.mass }));
                self.with_law(Gravity { g: *g, softening: *softening })
            }
            CaseLaw::Coulomb(k) => self.with_law(Coulomb { k: *k, softening: 0.0 }),
            CaseLaw::UniformGravity(g) => {
                self.builder = self.builder.constant(GravityAcceleration, [*g]);
                self.with_law(UniformGravity)
            }
            CaseLaw::Attractors(centers) => {
                self.pull.points.extend(centers.iter().map(|(gm, at)| Point { at: *at, strength: -gm }));
                self
            }
            CaseLaw::RotatingFrame(rate) => self.with_law(RotatingFrame { angular_velocity: DVec3::Z * *rate }),
            CaseLaw::Drag(linear, quadratic, wind) => {
                if *wind != [0.0; 3] {
                    self.bodies = self.bodies.with(WindVelocity, vec![*wind; rows]);
                }
                if *linear != 0.0 {
                    self.bodies = self.bodies.with(DragCoefficient, vec![*linear; rows]);
                    self.builder = self.builder.law(Drag);
                }
                if *quadratic != 0.0 {
                    self.bodies = self.bodies.with(QuadraticDragCoefficient, vec![*quadratic; rows]);
                    self.builder = self.builder.law(QuadraticDrag);
                }
                self
            }
            CaseLaw::Electric(value, region) => {
                self.electric.boxes.push(field_box(*value, region));
                self
            }
            CaseLaw::Magnetic(value, region) => {
                self.magnetic.boxes.push(field_box(*value, region));
                self
            }
            CaseLaw::Bottle(value, length) => {
                self.builder = self.builder.field(MagneticField, Bottle { value: *value, length: *length });
                self.bottle = true;
                self
            }
            CaseLaw::Springs(springs) => {
                let domain = Domain::new("springs")
                    .link(Ends, BODIES, ends(springs))
                    .with(Stiffness, springs.iter().map(|spring| spring.stiffness).collect::<Vec<_>>())
                    .with(RestLength, springs.iter().map(|spring| spring.rest).collect::<Vec<_>>());
                let damping: Vec<f64> = springs.iter().map(|spring| spring.damping).collect();
                let damped = damping.iter().any(|damping| *damping != 0.0);
                let domain = if damped { domain.with(Damping, damping) } else { domain };
                self.builder = self.builder.domain(domain).law(HookeSpring);
                if damped { self.with_law(Damper) } else { self }
            }
            CaseLaw::QuarticSprings(springs) => {
                let domain = Domain::new("quartic_springs")
                    .link(Ends, BODIES, ends(springs))
                    .with(QuarticStiffness, springs.iter().map(|spring| spring.stiffness).collect::<Vec<_>>());
                self.builder = self.builder.domain(domain);
                self.with_law(QuarticSpring)
            }
            CaseLaw::Driven(body, amplitude, [rate, phase]) => {
                self.bodies = self.bodies.subset(DrivingAmplitude, [*body], [*amplitude]);
                self.with_law(DrivenForce { angular_frequency: *rate, phase: *phase })
            }
            CaseLaw::HenonHeiles(cubic) => self.with_law(HenonHeiles { stiffness: 1.0, cubic: *cubic }),
            CaseLaw::Contact(normal, [offset, stiffness, damping, friction]) => self.with_law(ContactPlane {
                normal: DVec3::from_array(*normal),
                offset: *offset,
                stiffness: *stiffness,
                damping: *damping,
                friction: *friction,
                resting_speed: 1e-6,
            }),
        }
    }

    fn finish(mut self, case: &Case) -> Builder<P> {
        if !self.pull.points.is_empty() {
            self.builder = self.builder.field(GravityField, self.pull).law(FieldGravity);
        }
        let everywhere = |boxes: &Boxes| match boxes.boxes[..] {
            [only] if only.min == [f64::NEG_INFINITY; 3] && only.max == [f64::INFINITY; 3] => Some(only.value),
            _ => None,
        };
        let (electric, magnetic) = (!self.electric.boxes.is_empty(), !self.magnetic.boxes.is_empty());
        if electric {
            self.builder = match everywhere(&self.electric) {
                Some(value) => self.builder.field(ElectricField, Uniform { value }),
                None => self.builder.field(ElectricField, self.electric),
            }
            .law(ElectricForce);
        }
        if magnetic {
            self.builder = match everywhere(&self.magnetic) {
                Some(value) => self.builder.field(MagneticField, Uniform { value }),
                None => self.builder.field(MagneticField, self.magnetic),
            };
        }
        if magnetic || self.bottle {
            self.builder = self.builder.law(MagneticForce);
            if case.light.is_some() {
                self.builder = self.builder.law(RelativisticVelocity);
            }
        }
        let coulomb = case.laws.iter().any(|law| matches!(law, CaseLaw::Coulomb(_)));
        if electric || magnetic || self.bottle || coulomb {
            self.bodies = self.bodies.with(Charge, case.bodies.iter().map(|body| body.charge).collect::<Vec<_>>());
        }
        self.builder.domain(self.bodies)
    }
}

fn ends(springs: &[Spring]) -> Vec<[u32; 2]> {
    springs.iter().map(|spring| spring.ends).collect()
}

fn field_box(value: [f64; 3], region: &Option<Region>) -> FieldBox {
    let [min, max] = region.unwrap_or([[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]]);
    FieldBox { min, max, value }
}

/// Positions and velocities; `None` where an engine does not have them.
pub(super) fn numbers<P: Precision>(case: &Case, engine: &Engine<P>) -> Option<Vec<Vec<f64>>> {
    Some(vec![engine.state().numbers(BODIES, Position).ok()?, velocities(case, engine)?])
}

fn velocities<P: Precision>(case: &Case, engine: &Engine<P>) -> Option<Vec<f64>> {
    let Some(light) = case.light else { return engine.state().numbers(BODIES, Velocity).ok() };
    let momenta = engine.state().numbers(BODIES, Momentum).ok()?;
    let velocity = |(momentum, body): (&[f64], &Body)| {
        let momentum = DVec3::from_slice(momentum);
        let moving = (body.mass * body.mass + momentum.length_squared() / (light * light)).sqrt();
        if body.fixed { [0.0; 3] } else { (momentum / moving).to_array() }
    };
    Some(momenta.chunks_exact(3).zip(&case.bodies).flat_map(velocity).collect())
}
