//! Pipelines with laws here and there, whatever the client does between steps.

#[cfg(test)]
mod tests {
    use crate::backend::gpu::{Device, Transfers};
    use crate::domain::AsProperty;
    use crate::engine::device::GIVEN;
    use crate::prelude::*;
    use crate::property::{Ends, ExternalForce};
    use std::sync::Arc;

    property! {
        /// How fast a row is.
        Speed: Scalar, "m^2/s^2";
        /// What a row remembers.
        Memory: Scalar, "m";
        /// A constant that is given.
        Base: Scalar, "N";
        /// One that a law sets from it.
        Gain: Scalar, "N";
    }

    // No law divides: without a driver, what a device computes is 0, or what was there before.

    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(position: Position, mass: Mass), adds(force: Force))]
    struct Pull;

    #[kernel]
    impl<R: Real> RowLaw<R> for Pull {
        fn row(&self, row: PullRow<R>) -> R::Vec3 {
            -(row.position * row.mass)
        }
    }

    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(velocity: Velocity), adds(force: Force))]
    struct Slow;

    #[kernel]
    impl<R: Real> RowLaw<R> for Slow {
        fn row(&self, row: SlowRow<R>) -> R::Vec3 {
            -row.velocity
        }
    }

    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(position: Position), adds(force: Force))]
    struct Attract;

    #[kernel]
    impl<R: Real> PairLaw<R> for Attract {
        fn pair(&self, i: AttractRow<R>, j: AttractRow<R>) -> R::Vec3 {
            j.position - i.position
        }
    }

    #[derive(Law, Clone, Copy, Debug)]
    #[law(link(ends: Ends, reads(position: Position), adds(force: Force)))]
    struct Tie;

    #[kernel]
    impl<R: Real> LinkLaw<R, 2> for Tie {
        fn link(&self, _: TieRow<R>, [a, b]: [TieEnd<R>; 2]) -> [R::Vec3; 2] {
            [b.position - a.position, a.position - b.position]
        }
    }

    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(position: Position), adds(force: Force))]
    struct Centre;

    #[kernel]
    impl<P: Precision> ColumnLaw<P> for Centre {
        fn columns(&self, mut rows: CentreColumns<'_, P>) {
            for row in 0..rows.position.len() {
                let place = rows.position.get(row);
                rows.force.add(row, -place);
            }
        }
    }

    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(position: Position, previous before: Memory), sets(memory: Memory), adds(force: Force))]
    struct Remember;

    #[kernel]
    impl<R: Real> RowLaw<R> for Remember {
        fn row(&self, row: RememberRow<R>) -> RememberOutput<R> {
            let memory = row.before * R::lit(0.5) + row.position.x();
            RememberOutput { memory, force: R::Vec3::new(memory, memory, memory) }
        }
    }

    #[derive(Law, Clone, Copy, Debug)]
    #[law(domain = "scene", reads(base: Base), sets(gain: Gain))]
    struct Amplify;

    #[kernel]
    impl<R: Real> RowLaw<R> for Amplify {
        fn row(&self, row: AmplifyRow<R>) -> R {
            row.base * R::lit(3.0)
        }
    }

    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(velocity: Velocity), scene(gain: Gain), adds(force: Force))]
    struct Push;

    #[kernel]
    impl<R: Real> RowLaw<R> for Push {
        fn row(&self, row: PushRow<R>) -> R::Vec3 {
            R::Vec3::new(row.gain, row.gain, row.velocity.x())
        }
    }

    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(velocity: Velocity), sets(speed: Speed))]
    struct Measure;

    #[kernel]
    impl<R: Real> RowLaw<R> for Measure {
        fn row(&self, row: MeasureRow<R>) -> R {
            row.velocity.length_squared()
        }
    }

    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(force: Force, velocity: Velocity), rates(moves: Position from (velocity), kicks: Velocity from (force)))]
    struct Move;

    #[kernel]
    impl<R: Real> RowLaw<R> for Move {
        fn row(&self, row: MoveRow<R>) -> MoveOutput<R> {
            MoveOutput { moves: row.velocity, kicks: row.force }
        }
    }

    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(velocity: Velocity), amends(corrected: Velocity))]
    struct Brake;

    #[kernel]
    impl<R: Real> RowLaw<R> for Brake {
        fn row(&self, row: BrakeRow<R>) -> R::Vec3 {
            row.velocity * R::lit(0.5)
        }
    }

    /// Numbers of a fixed sequence (Knuth's linear congruential generator, MMIX).
    struct Dice {
        seed: u64,
        /// Whether all laws run on the host.
        host: bool,
    }

    impl Dice {
        fn below(&mut self, faces: u64) -> u64 {
            self.seed = self.seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.seed >> 33) % faces
        }

        fn backend(&mut self) -> Backend {
            if self.below(2) == 0 && !self.host { Backend::Gpu } else { Backend::Cpu }
        }
    }

    /// A device that engines of this thread share.
    struct Given;

    impl Given {
        fn new(device: Device) -> Self {
            GIVEN.set(Some(Arc::new(device)));
            Given
        }
    }

    impl Drop for Given {
        fn drop(&mut self) {
            GIVEN.set(None);
        }
    }

    /// Some laws, some here and some there, under some integrator that takes them.
    fn crowd(dice: &mut Dice) -> Engine<f32> {
        let rows = [0, 1, 2, 63, 100, 700][dice.below(6) as usize];
        let numbers: Vec<DVec3> = (0..rows).map(|row| DVec3::new(row as f64 * 0.0625, 1.0, -2.0)).collect();
        let mut bodies = Domain::new("rows").rows(rows).with(Position, numbers.clone()).with(Velocity, numbers.clone());
        bodies = bodies.with(Mass, vec![1.0; rows]);
        if dice.below(3) == 0 {
            bodies = bodies.with(ExternalForce, numbers);
        }
        let mut builder = Engine::<f32>::builder().domain(bodies);
        if rows > 1 && dice.below(2) == 0 {
            let ties: Vec<[u32; 2]> = (1..rows as u32).map(|row| [row - 1, row]).collect();
            builder = builder.domain(Domain::new("ties").rows(rows - 1).link(Ends, "rows", ties));
            builder = builder.law(Tie.backend(dice.backend()));
        }
        builder = builder.law(Move.backend(dice.backend()));
        // Not on every step, one in three times.
        let every = |dice: &mut Dice| if dice.below(3) == 0 { 2 + dice.below(2) as u32 } else { 1 };
        macro_rules! perhaps {
            ($($law:expr),*) => {$(
                if dice.below(2) == 0 {
                    builder = builder.law($law.every(every(dice)).backend(dice.backend()));
                }
            )*};
        }
        let slow = dice.below(2) == 0;
        if slow {
            builder = builder.law(Slow.backend(dice.backend()));
            builder =
                builder.constant(Base, 0.5).law(Amplify.backend(dice.backend())).law(Push.backend(dice.backend()));
        }
        perhaps!(Pull, Attract, Centre);
        if dice.below(3) == 0 {
            builder = builder.law(Remember.backend(dice.backend()));
        }
        if dice.below(2) == 0 {
            builder = builder.law(Measure.backend(dice.backend())).observe("rows", Speed);
        }
        if dice.below(4) == 0 {
            builder = builder.law(Brake.backend(dice.backend()));
        }
        for property in [Position.info(), Velocity.info(), Force.info()] {
            if dice.below(2) == 0 {
                builder = builder.observe("rows", property);
            }
        }
        if dice.below(8) == 0 {
            builder = builder.compensated();
        }
        let builder = match dice.below(7) {
            0 => builder.integrator(ExplicitEuler),
            1 => builder.integrator(SemiImplicitEuler),
            2 => builder.integrator(Midpoint),
            3 => builder.integrator(RungeKutta4),
            4 if !slow => builder.integrator(DriftKickDrift),
            _ => builder.integrator(Leapfrog::default()),
        };
        builder.step(1.0 / 64.0).build().unwrap()
    }

    /// What laws find where they run is what they would find on the host.
    #[test]
    fn numbers_are_where_laws_look_for_them() {
        if here_and_there().is_none() {
            return;
        }
        let _given = Given::new(Device::open().unwrap());
        let [mut dice, mut same] = [false, true].map(|host| Dice { seed: 2, host });
        let mut on_device = 0;
        for number in 0..60 {
            let [mut there, mut here] = [crowd(&mut dice), crowd(&mut same)];
            on_device += usize::from(there.backends().contains(&Some(Backend::Gpu)));
            for engine in [&mut there, &mut here] {
                // Once with looks between, once without: what is observed is brought back or not.
                (0..3).for_each(|_| engine.advance(1.0 / 64.0).unwrap());
                engine.state().numbers("rows", Position.info()).unwrap();
                engine.steps_of(3, 1.0 / 64.0).unwrap();
            }
            for property in [Position.info(), Velocity.info()] {
                let [a, b] = [&there, &here].map(|engine| engine.state().numbers("rows", property).unwrap());
                let largest = b.iter().fold(0.0, |largest, number| f64::max(largest, number.abs()));
                let off = a.iter().zip(&b).fold(0.0, |off, (a, b)| f64::max(off, (a - b).abs()));
                let text = there.explain();
                assert!(off <= 1e-5 * largest, "pipeline {number}, {}: {off} of {largest}\n{text}", property.name);
            }
        }
        assert!(on_device > 40, "{on_device}");
    }

    fn engine(backend: Backend) -> Engine<f32> {
        let places: Vec<DVec3> = (0..300).map(|row| DVec3::new(f64::from(row), 1.0, -0.25)).collect();
        let rows = Domain::new("rows").rows(300).with(Position, places).with(Velocity, vec![DVec3::Z; 300]);
        let builder = Engine::<f32>::builder().domain(rows.with(Mass, vec![0.5; 300])).law(Pull.backend(backend));
        builder.law(Move.backend(backend)).integrator(SemiImplicitEuler).step(0.125).build().unwrap()
    }

    /// The same engine on the host and on a device, if there is one; without one the test says so, and with `VESPER_REQUIRE_GPU=1` it fails.
    fn here_and_there() -> Option<[Engine<f32>; 2]> {
        let engines = [Backend::Cpu, Backend::Gpu].map(engine);
        if engines[1].backends() != [Some(Backend::Gpu); 2] {
            let required = std::env::var("VESPER_REQUIRE_GPU").is_ok_and(|required| required == "1");
            assert!(!required, "{}", engines[1].explain());
            eprintln!("not run: {}", engines[1].explain());
            return None;
        }
        Some(engines)
    }

    fn unplug(engine: &Engine<f32>) {
        engine.machine.device.as_ref().unwrap().as_ref().unwrap().destroy();
    }

    #[test]
    fn a_device_that_is_lost_changes_no_number_that_was_looked_at() {
        let Some([mut here, mut there]) = here_and_there() else { return };
        here.steps_of(4, 0.125).unwrap();
        there.steps_of(4, 0.125).unwrap();
        assert_eq!(here.state().hash(), there.state().hash());
        unplug(&there);
        here.steps_of(4, 0.125).unwrap();
        there.steps_of(4, 0.125).unwrap();
        assert_eq!(here.state().hash(), there.state().hash());
        assert_eq!(there.backends(), [Some(Backend::Cpu); 2]);
        let text = there.explain();
        assert!(text.contains("    not on the graphics processor: it is gone") && text.contains("  rows: "), "{text}");
    }

    /// A pipeline that is made after the loss asks the device for nothing.
    #[test]
    fn laws_may_be_switched_after_a_device_is_lost() {
        let Some([mut here, mut there]) = here_and_there() else { return };
        for engine in [&mut here, &mut there] {
            engine.steps_of(4, 0.125).unwrap();
            engine.state().hash();
        }
        unplug(&there);
        for engine in [&mut here, &mut there] {
            engine.steps_of(1, 0.125).unwrap();
            engine.enable("pull", false).unwrap();
            engine.steps_of(2, 0.125).unwrap();
            engine.enable("pull", true).unwrap();
            engine.steps_of(1, 0.125).unwrap();
        }
        assert_eq!(here.state().hash(), there.state().hash());
        assert_eq!(there.backends(), [Some(Backend::Cpu); 2]);
    }

    #[test]
    fn numbers_that_are_lost_with_a_device_are_none_and_the_client_is_told() {
        let Some([mut here, mut there]) = here_and_there() else { return };
        here.steps_of(4, 0.125).unwrap();
        there.steps_of(4, 0.125).unwrap();
        let checkpoint = there.checkpoint().unwrap();
        there.steps_of(2, 0.125).unwrap();
        unplug(&there);
        let places = there.state().numbers("rows", Position.info()).unwrap();
        assert!(places.iter().all(|number| number.is_nan()), "{places:?}");
        let told = there.steps_of(1, 0.125).unwrap_err().to_string();
        assert!(told.contains("the graphics processor is gone") && told.contains("checkpoint"), "{told}");
        assert!(there.steps_of(1, 0.125).is_err(), "nothing goes on from numbers that are none");
        there.restore(&checkpoint).unwrap();
        here.steps_of(4, 0.125).unwrap();
        there.steps_of(4, 0.125).unwrap();
        assert_eq!(here.state().hash(), there.state().hash());
    }

    /// Whatever the client does between steps, numbers are where it looks.
    #[test]
    fn clients_may_look_and_change_between_steps() {
        let Some(mut engines) = here_and_there() else { return };
        for engine in &mut engines {
            engine.steps_of(2, 0.125).unwrap();
            engine.state_mut().set("rows", Velocity, 7, [1.0, 2.0, 3.0].into()).unwrap();
            engine.steps_of(2, 0.125).unwrap();
            let mut columns = engine.state_mut().column_mut("rows", "position").unwrap().components_mut().unwrap();
            columns[1][3] = 4.0;
            engine.steps_of(1, 0.125).unwrap();
            engine.state_mut().remove_rows("rows", &[0, 5, 299]).unwrap();
            engine.steps_of(3, 0.125).unwrap();
            let more = Domain::new("rows").rows(2).with(Position, [DVec3::X; 2]).with(Mass, [1.0; 2]);
            engine.state_mut().add_rows(more.with(Velocity, [DVec3::Y; 2])).unwrap();
            engine.enable("pull", false).unwrap();
            engine.steps_of(1, 0.125).unwrap();
            engine.enable("pull", true).unwrap();
            engine.steps_of(1, 0.125).unwrap();
            let copy = engine.state().clone();
            assert_eq!(copy.hash(), engine.state().hash());
            engine.state_mut().remove_column("rows", Mass).unwrap();
            engine.steps_of(1, 0.125).unwrap();
        }
        let [here, there] = engines;
        assert_eq!(here.state().hash(), there.state().hash());
    }

    /// Numbers follow their state to another engine, whose laws run elsewhere.
    #[test]
    fn states_may_change_engines() {
        let Some([mut here, mut there]) = here_and_there() else { return };
        let mut alone = engine(Backend::Cpu);
        for engine in [&mut here, &mut there, &mut alone] {
            engine.steps_of(3, 0.125).unwrap();
        }
        core::mem::swap(here.state_mut(), there.state_mut());
        for engine in [&mut here, &mut there, &mut alone] {
            engine.steps_of(3, 0.125).unwrap();
        }
        for engine in [&here, &there] {
            assert_eq!(engine.state().hash(), alone.state().hash());
        }
        let kept = core::mem::replace(there.state_mut(), here.state().clone());
        drop(there);
        assert_eq!(kept.hash(), alone.state().hash());
    }

    /// A state of another shape in the place of one whose numbers are on a device.
    #[test]
    fn a_state_may_be_replaced_by_a_smaller_one() {
        let Some([_, mut there]) = here_and_there() else { return };
        there.steps_of(3, 0.125).unwrap();
        let rows = Domain::new("rows").rows(2).with(Position, [DVec3::X; 2]).with(Mass, [1.0; 2]);
        let other = Engine::<f32>::builder().domain(rows.with(Velocity, [DVec3::Y; 2])).build().unwrap();
        *there.state_mut() = other.state().clone();
        there.steps_of(3, 0.125).unwrap();
        assert_eq!(there.state().numbers("rows", Position).unwrap().len(), 6);
    }

    /// A pull that is none once a row is at the origin.
    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(position: Position), adds(force: Force))]
    struct Singular;

    #[kernel]
    impl<R: Real> RowLaw<R> for Singular {
        fn row(&self, row: SingularRow<R>) -> R::Vec3 {
            row.position * (R::lit(1.0) / row.position.x()).sqrt()
        }
    }

    /// Nobody looks, and yet the step and the law are found.
    #[test]
    fn a_number_that_becomes_none_on_a_device_is_traced() {
        if here_and_there().is_none() {
            return;
        }
        let rows = Domain::new("rows").rows(2).with(Position, [DVec3::X; 2]).with(Velocity, [DVec3::X * -4.0; 2]);
        let builder = Engine::<f32>::builder().domain(rows).law(Singular).law(Move).backend(Backend::Gpu);
        let mut engine = builder.integrator(SemiImplicitEuler).step(0.125).build().unwrap();
        engine.trace_blow_ups(true);
        let told = (0..8).find_map(|_| engine.advance(0.125).err()).unwrap().to_string();
        assert!(told.contains("singular is the first law whose result is not finite"), "{told}");
        let places = engine.state().numbers("rows", Position).unwrap();
        assert!(places.iter().all(|number| number.is_finite()), "{places:?}");
    }

    fn counts(now: Transfers, before: Transfers) -> [u64; 4] {
        let of = |moved: Transfers| [moved.uploads, moved.uploaded, moved.downloads, moved.downloaded];
        core::array::from_fn(|k| of(now)[k] - of(before)[k])
    }

    /// What is foreseen is what moves: to the byte, in every frame, whatever runs where.
    #[test]
    fn planned_moves_are_the_moves() {
        let _given = Given::new(Device::without_driver());
        let (mut dice, mut moved, mut on_device) = (Dice { seed: 1, host: false }, 0, 0);
        for number in 0.. {
            if on_device == 200 {
                break;
            }
            let mut engine = crowd(&mut dice);
            // As it was foreseen when the engine was built, but for more frames.
            let Some(foreseen) = engine.pipeline.foresee_frames(&mut *engine.integrator, 6) else { continue };
            on_device += 1;
            let observed = engine.observe.clone();
            let look = |engine: &Engine<f32>| {
                for (domain, property) in &observed {
                    let column = engine.state().column(domain, property).unwrap();
                    assert!(column.components().is_some());
                }
            };
            look(&engine);
            let mut before = engine.transfers();
            for frame in 1..foreseen.len() {
                engine.advance(1.0 / 64.0).unwrap();
                look(&engine);
                let now = engine.transfers();
                let planned = foreseen.counts(frame);
                assert_eq!(counts(now, before), planned, "pipeline {number}, frame {frame}:\n{}", engine.explain());
                moved += planned[1] + planned[3];
                before = now;
            }
        }
        assert!(moved > 1 << 20, "{moved} bytes");
    }
}
