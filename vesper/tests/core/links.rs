//! Laws of links: each row sums the shares of its links in their order, whatever lanes and threads there are, wherever numbers are.

use crate::common::*;
use vesper::backend::Compile;
use vesper::prelude::*;
use vesper::property::Corners;
use vesper::real::Isa;

property! {
    /// The two bonds of a dihedral angle, and what turns about them.
    Dihedral: Link<4>;
}

/// Three corners that drift to a place of their own, the charged ones more.
#[derive(Law, Clone, Copy, Debug)]
#[law(domain = "links", reads(stiffness: Stiffness, colour: Colour), scene(gravity: GravityAcceleration = [0.1, 0.2, 0.3]),
      link(corners: Corners, reads(position: Position, mass: Mass), reads(charge: Charge, optional), adds(force: Force)))]
struct Membrane;

#[kernel]
impl<R: Real> LinkLaw<R, 3> for Membrane {
    fn link(&self, row: MembraneRow<R>, [a, b, c]: [MembraneEnd<R>; 3]) -> [R::Vec3; 3] {
        let centre = (a.position + b.position + c.position) * R::lit(1.0 / 3.0) + row.colour + row.gravity;
        [a, b, c].map(|corner| {
            let pull = row.stiffness * corner.mass + corner.charge.unwrap_or(R::lit(0.25));
            (centre - corner.position) * pull
        })
    }
}

/// Four rows that turn about each other.
#[derive(Law, Clone, Copy, Debug)]
#[law(domain = "links", reads(stiffness: Stiffness), link(rows: Dihedral, reads(position: Position), adds(force: Force)))]
struct Torsion;

#[kernel]
impl<R: Real> LinkLaw<R, 4> for Torsion {
    fn link(&self, row: TorsionRow<R>, [a, b, c, d]: [TorsionEnd<R>; 4]) -> [R::Vec3; 4] {
        let (ab, bc, cd) = (b.position - a.position, c.position - b.position, d.position - c.position);
        let turn = ab.cross(bc) * row.stiffness;
        [turn, bc.cross(cd), -turn, ab * (bc.dot(cd) * row.stiffness)]
    }
}

/// What ends where.
#[derive(Clone, Copy, Debug)]
enum Shape {
    /// Anywhere, now and then twice at one row.
    Anywhere,
    /// At neighbours.
    Near,
    /// At the first row, and somewhere else.
    Star,
}

const ROWS: usize = 211;
const MACHINES: [(Backend, usize); 5] =
    [(Backend::Cpu, 1), (Backend::Parallel, 1), (Backend::Parallel, 2), (Backend::Parallel, 3), (Backend::Parallel, 7)];

fn ends<const N: usize>(count: usize, shape: Shape, random: &mut Random) -> Vec<[u32; N]> {
    let mut link = |link: usize| {
        let from = link * ROWS / count;
        core::array::from_fn(|end| match shape {
            Shape::Anywhere => random.below(ROWS),
            Shape::Near => (from + end * random.below(3)).min(ROWS - 1),
            Shape::Star => end.min(1) * random.below(ROWS),
        } as u32)
    };
    (0..count).map(&mut link).collect()
}

/// Everything that one of the laws here reads.
struct Scene<P, const N: usize> {
    link: PropertyInfo,
    ends: Vec<[u32; N]>,
    position: Vec<[P; 3]>,
    mass: Vec<[P; 1]>,
    charge: Option<Vec<f64>>,
    stiffness: Vec<[P; 1]>,
    colour: Vec<[P; 3]>,
}

impl<P: Precision, const N: usize> Scene<P, N> {
    fn new(link: PropertyInfo, count: usize, shape: Shape, charged: bool) -> Self {
        let mut random = Random(count as u64);
        let ends = ends(count, shape, &mut random);
        let mut vectors = |rows: usize| (0..rows).map(|_| random.vector().map(P::from_f64)).collect::<Vec<_>>();
        let (position, colour) = (vectors(ROWS), vectors(count));
        let mut numbers = |rows: usize| (0..rows).map(|_| [P::from_f64(random.unit())]).collect::<Vec<_>>();
        let (mass, stiffness) = (numbers(ROWS), numbers(count));
        let charge = charged.then(|| numbers(ROWS).iter().map(|[number]| number.to_f64()).collect());
        Scene { link, ends, position, mass, charge, stiffness, colour }
    }

    /// The forces that a law gives, as bits; with `lent` all that can be is in the client's memory, one row after the other.
    fn run(&self, law: impl Compile + Clone, lent: bool, isa: Isa, (backend, threads): (Backend, usize)) -> Vec<u64> {
        let links = Domain::new("links").with_link(self.link, "bodies", self.ends.as_flattened().to_vec());
        let bodies = Domain::new("bodies");
        let bodies = match &self.charge {
            Some(charge) => bodies.with(Charge, charge),
            None => bodies,
        };
        let domains = if lent {
            let links = links.lend(Stiffness, &Lent::new(self.stiffness.clone()));
            let links = links.lend(Colour, &Lent::new(self.colour.clone()));
            let bodies = bodies.lend(Position, &Lent::new(self.position.clone()));
            [links, bodies.lend(Mass, &Lent::new(self.mass.clone()))]
        } else {
            let plain = |rows: &[[P; 1]]| rows.iter().map(|[number]| number.to_f64()).collect::<Vec<_>>();
            let vectors = |rows: &[[P; 3]]| rows.iter().map(|row| row.map(P::to_f64)).collect::<Vec<_>>();
            let links = links.with(Stiffness, plain(&self.stiffness)).with(Colour, vectors(&self.colour));
            [links, bodies.with(Position, vectors(&self.position)).with(Mass, plain(&self.mass))]
        };
        let builder = domains.into_iter().fold(Engine::<P>::builder(), Builder::domain);
        let builder = builder.law(law).step(1e-3).isa(isa);
        let mut engine = builder.backend(backend).threads(threads).observe("bodies", Force).build().unwrap();
        engine.steps_of(1, 1e-3).unwrap();
        engine.state().numbers("bodies", Force).unwrap().into_iter().map(|number| P::from_f64(number).bits()).collect()
    }

    /// The same by the plainest loop.
    fn expected(&self, shares: impl Fn(usize, [u32; N]) -> [P::Vec3; N]) -> Vec<u64> {
        let mut force = [P::Vec3::zero(); ROWS];
        for (link, ends) in self.ends.iter().enumerate() {
            for (end, share) in ends.iter().zip(shares(link, *ends)) {
                force[*end as usize] += share;
            }
        }
        force.iter().flat_map(|force| [force.x(), force.y(), force.z()].map(P::bits)).collect()
    }

    fn place(&self, row: u32) -> P::Vec3 {
        let [x, y, z] = self.position[row as usize];
        P::Vec3::new(x, y, z)
    }

    fn same_everywhere(&self, law: impl Compile + Clone, shares: impl Fn(usize, [u32; N]) -> [P::Vec3; N]) {
        let expected = self.expected(shares);
        for isa in Isa::available() {
            for (machine, lent) in MACHINES.into_iter().flat_map(|machine| [(machine, false), (machine, true)]) {
                let found = self.run(law.clone(), lent, isa, machine);
                let count = self.ends.len();
                // Not `assert_eq`, which would print hundreds of numbers.
                assert!(
                    found == expected,
                    "{count} links of {N} rows, {}: {isa:?}, {machine:?}, lent: {lent}",
                    P::NAME
                );
            }
        }
    }
}

fn every_arity<P: Precision>(counts: &[usize]) {
    for (&count, shape) in
        counts.iter().flat_map(|count| [Shape::Anywhere, Shape::Near, Shape::Star].map(|s| (count, s)))
    {
        let scene = Scene::<P, 2>::new(Ends::INFO, count, shape, false);
        scene.same_everywhere(Joint, |link, ends| {
            let row = JointRow { stiffness: scene.stiffness[link][0] };
            Joint.link(row, ends.map(|end| JointEnd { position: scene.place(end) }))
        });
        for charged in [false, true] {
            let scene = Scene::<P, 3>::new(Corners::INFO, count, shape, charged);
            scene.same_everywhere(Membrane, |link, ends| {
                let [x, y, z] = scene.colour[link];
                let gravity = P::Vec3::new(P::lit(0.1), P::lit(0.2), P::lit(0.3));
                let colour = P::Vec3::new(x, y, z);
                let row = MembraneRow { stiffness: scene.stiffness[link][0], colour, gravity };
                let corner = |row: u32| MembraneEnd {
                    position: scene.place(row),
                    mass: scene.mass[row as usize][0],
                    charge: scene.charge.as_ref().map(|charge| P::from_f64(charge[row as usize])),
                };
                Membrane.link(row, ends.map(corner))
            });
        }
        let scene = Scene::<P, 4>::new(Dihedral::INFO, count, shape, false);
        scene.same_everywhere(Torsion, |link, ends| {
            let row = TorsionRow { stiffness: scene.stiffness[link][0] };
            Torsion.link(row, ends.map(|end| TorsionEnd { position: scene.place(end) }))
        });
    }
}

/// A spring at ease at no length.
#[derive(Law, Clone, Copy, Debug)]
#[law(domain = "links", reads(stiffness: Stiffness), link(ends: Ends, reads(position: Position), adds(force: Force)))]
struct Joint;

#[kernel]
impl<R: Real> LinkLaw<R> for Joint {
    fn link(&self, joint: JointRow<R>, [a, b]: [JointEnd<R>; 2]) -> [R::Vec3; 2] {
        let d = b.position - a.position;
        let force = d * (joint.stiffness * d.length());
        [force, -force]
    }
}

const FEW: [usize; 16] = [0, 1, 2, 3, 7, 8, 9, 15, 16, 17, 31, 63, 64, 65, 127, 131];

#[test]
fn few_links_sum_in_their_order() {
    every_arity::<f32>(&FEW);
    every_arity::<f64>(&FEW);
}

#[test]
fn many_links_sum_in_their_order_on_any_number_of_threads() {
    every_arity::<f32>(&[1023, 4999]);
    every_arity::<f64>(&[1023, 4999]);
}

#[test]
fn links_of_double_double_numbers_sum_in_their_order() {
    let scene = Scene::<DoubleDouble, 2>::new(Ends::INFO, 3001, Shape::Anywhere, false);
    let reference = scene.run(Joint, false, Isa::Scalar, MACHINES[0]);
    assert!(reference.iter().any(|bits| *bits != 0));
    for machine in MACHINES {
        assert!(scene.run(Joint, false, Isa::detect(), machine) == reference, "{machine:?}");
    }
}
