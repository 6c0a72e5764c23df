//! Expansions of right declarations: they are items of Rust, and hold what the core expects.

use super::{plain, tokens};

/// The expansion, which must be items, without spaces.
fn law(text: &str) -> String {
    let expansion = crate::law(tokens(text));
    if let Err(error) = syn::parse2::<syn::File>(expansion.clone()) {
        panic!("{error}: {expansion}");
    }
    plain(&expansion)
}

fn holds(expansion: &str, fragments: &[&str]) {
    for fragment in fragments {
        let fragment: String = fragment.split_whitespace().collect();
        assert!(expansion.contains(&fragment), "no `{fragment}` in\n{expansion}");
    }
    assert!(!expansion.contains("compile_error"), "{expansion}");
}

/// A struct's fields.
fn fields(text: &str, name: &str) -> Vec<String> {
    let file: syn::File = syn::parse2(crate::law(tokens(text))).unwrap_or_else(|error| panic!("{error}"));
    let found = file.items.iter().find_map(|item| match item {
        syn::Item::Struct(item) if item.ident == name => Some(item),
        _ => None,
    });
    let found = found.unwrap_or_else(|| panic!("no struct {name}"));
    found.fields.iter().filter_map(|field| field.ident.as_ref().map(ToString::to_string)).collect()
}

const GRAVITY: &str = "
    /// Newton's law.
    ///
    /// Softened.
    #[law(domain = \"bodies\", reads(position: Position, mass: Mass), adds(force: Force))]
    pub struct Gravity<R = f64> {
        /// Constant.
        #[law(unit = \"m^3 kg^-1 s^-2\", default = 6.674_30e-11)]
        pub g: R,
        #[law(unit = \"m\", default = 0.0)]
        pub softening: R,
    }";

#[test]
fn a_pair_law() {
    holds(
        &law(GRAVITY),
        &[
            "pub struct GravityRow<R: ::vesper::real::Real>",
            "pub position: ::vesper::property::ValueOf<Position, R>",
            "const SLOTS: [usize; 4usize] = ::vesper::law::slots(&[<Position as ::vesper::property::Property>::INFO.kind.width(),",
            "impl<R: ::vesper::real::Real> ::vesper::law::Declared<R> for Gravity<R>",
            "type Row = GravityRow<R>; type End = (); type Output = ::vesper::property::ValueOf<Force, R>; type EndOutput = ();",
            "mass: ::vesper::law::read::<Mass, R, VesperSource>(source, ::vesper::law::Place::Own, 1usize, SLOTS[1usize])",
            "::vesper::law::write::<Force, R, VesperSink>(sink, ::vesper::law::Mode::Adds, SLOTS[2usize], output);",
            "impl ::vesper::law::Law for Gravity<f64>",
            "name: \"gravity\", doc: \"Newton's law.\\n\\nSoftened.\", domain: ::core::option::Option::Some(\"bodies\")",
            "field: \"force\", property: <Force as ::vesper::property::Property>::INFO, mode: ::vesper::law::Mode::Adds,
             place: ::vesper::law::Place::Own, optional: false, default: ::core::option::Option::None, from: u64::MAX",
            "name: \"g\", doc: \"Constant.\", unit: \"m^3 kg^-1 s^-2\", width: 1usize,
             default: ::core::option::Option::Some([0.000000000066743f64, 0f64, 0f64])",
            "type Body<R: ::vesper::real::Real> = Gravity<R>;",
            "softening: <R as ::vesper::real::Real>::lit(self.softening)",
            "fn from_parameters(values: &[f64]) -> Self { Self { g: values.get(0usize).copied().unwrap_or(0.000000000066743f64),
             softening: values.get(1usize).copied().unwrap_or(0f64), } }",
            "impl ::core::default::Default for Gravity<f64>",
            "needs_kernel::<Gravity<f64>>();",
            "pub struct GravityColumns<'a, P: ::vesper::real::Scalar>",
            "pub force: ::vesper::law::SliceMut<'a, Force, P>",
            "position: access.slice::<Position>(0usize)",
        ],
    );
}

#[test]
fn a_law_without_parameters() {
    let text = "#[law(reads(velocity: Velocity, mass: Mass, force: Force),
        rates(position: Position from (velocity), velocity: Velocity from (force, mass)))] pub(crate) struct Motion;";
    holds(
        &law(text),
        &[
            "pub(crate) struct MotionOutput<R: ::vesper::real::Real>",
            "impl<R: ::vesper::real::Real> ::vesper::law::Declared<R> for Motion {",
            "::vesper::law::write::<Position, R, VesperSink>(sink, ::vesper::law::Mode::Rates, SLOTS[3usize], output.position);",
            "impl ::vesper::law::Law for Motion {",
            "from: 1u64",
            "from: 6u64",
            "fn body<R: ::vesper::real::Real>(&self) -> Motion { Motion {} }",
            "fn from_parameters(_values: &[f64]) -> Self { Self {} }",
            "impl ::core::default::Default for Motion { fn default() -> Self { Self {} } }",
            "impl ::vesper::law::DeclaredColumns for Motion {",
            "needs_kernel::<Motion>();",
        ],
    );
    assert_eq!(fields(text, "MotionColumns"), ["velocity", "mass", "force", "position", "velocity_rate"]);
}

#[test]
fn every_group_and_kind_of_field() {
    let text = "#[law(adds(force: Force), fields(electric: ElectricField),
        scene(gravity: GravityAcceleration = [0, 0, -9.81], time: Time), scene(wind: WindVelocity, optional),
        reads(previous force: Force), reads(charge: Charge, optional), sets(power: Power))]
        struct Drag<T: Real = f64> {
            #[law(unit = \"m/s\", default = [0, -1, 2.5])] offset: <T as Real>::Vec3,
            #[law(unit = \"kg/s\")] k: T,
            #[law(skip)] memory: Vec<f64>,
            #[law(skip)] scratch: Vec<T>,
        }";
    let expansion = law(text);
    holds(
        &expansion,
        &[
            "force: ::vesper::law::read::<Force, T, VesperSource>(source, ::vesper::law::Place::Own, 0usize,",
            "charge: ::vesper::law::read_optional::<Charge, T, VesperSource>(source, ::vesper::law::Place::Own, 1usize,",
            "gravity: ::vesper::law::read::<GravityAcceleration, T, VesperSource>(source, ::vesper::law::Place::Scene, 2usize,",
            "time: ::vesper::law::read::<Time, T, VesperSource>(source, ::vesper::law::Place::Scene, 3usize,",
            "wind: ::vesper::law::read_optional::<WindVelocity, T, VesperSource>(source, ::vesper::law::Place::Scene, 4usize,",
            "electric: ::vesper::law::read::<ElectricField, T, VesperSource>(source, ::vesper::law::Place::Field, 5usize,",
            "::vesper::law::write::<Power, T, VesperSink>(sink, ::vesper::law::Mode::Sets, SLOTS[6usize], output.power);",
            "::vesper::law::write::<Force, T, VesperSink>(sink, ::vesper::law::Mode::Adds, SLOTS[7usize], output.force);",
            "pub wind: ::core::option::Option<::vesper::property::ValueOf<WindVelocity, T>>",
            "mode: ::vesper::law::Mode::Previous",
            "place: ::vesper::law::Place::Scene, optional: false, default: ::core::option::Option::Some([0f64, 0f64, -9.81f64])",
            "place: ::vesper::law::Place::Field",
            "width: 3usize, default: ::core::option::Option::Some([0f64, -1f64, 2.5f64])",
            "offset: <<T as ::vesper::real::Real>::Vec3 as ::vesper::real::Vector<T>>::lit(self.offset)",
            "memory: ::core::clone::Clone::clone(&self.memory)",
            "scratch: ::core::default::Default::default()",
            "::vesper::real::Vector<f64>>::new(values.get(0usize).copied().unwrap_or(0f64),
             values.get(1usize).copied().unwrap_or(-1f64), values.get(2usize).copied().unwrap_or(2.5f64)),
             k: values.get(3usize).copied().unwrap_or(f64::NAN)",
            "== 3usize, \"the default of constant `gravity` has 3 components, its property has not\"",
            "pub wind: ::core::option::Option<::vesper::property::ValueOf<WindVelocity, P>>",
            "charge: access.optional_slice::<Charge>(1usize)",
            "electric: access.slice::<ElectricField>(5usize)",
            "gravity: access.constant::<GravityAcceleration>(2usize)",
        ],
    );
    assert!(!expansion.contains("Defaultfor"), "`k` has no default, so the law has none");
    let columns = ["previous_force", "charge", "gravity", "time", "wind", "electric", "power", "force"];
    assert_eq!(fields(text, "DragColumns"), columns);
}

#[test]
fn a_link_law() {
    let text = "#[law(reads(position: Position, stiffness: Stiffness), amends(position: Position),
        link(ends: Ends, reads(position: Position), reads(mass: Mass, optional), adds(force: Force, torque: Torque)))]
        struct Spring;";
    holds(
        &law(text),
        &[
            "type End = SpringEnd<R>; type Output = ::vesper::property::ValueOf<Position, R>; type EndOutput = SpringEndOutput<R>;",
            "SpringEnd { position: ::vesper::law::read::<Position, R, VesperSource>(source, ::vesper::law::Place::End, 2usize, SLOTS[2usize]),
             mass: ::vesper::law::read_optional::<Mass, R, VesperSource>(source, ::vesper::law::Place::End, 3usize, SLOTS[3usize]), }",
            "::vesper::law::write::<Position, R, VesperSink>(sink, ::vesper::law::Mode::Amends, SLOTS[4usize], output);",
            "::vesper::law::write::<Torque, R, VesperSink>(sink, ::vesper::law::Mode::Adds, SLOTS[6usize], output.torque);",
            "link: ::core::option::Option::Some(<Ends as ::vesper::property::Property>::INFO)",
            "place: ::vesper::law::Place::End",
            "pub ends: ::vesper::law::LinkSlice<'a>",
            "ends: access.link()",
        ],
    );
    let columns = ["position", "stiffness", "position_amended", "ends", "ends_position", "mass", "force", "torque"];
    assert_eq!(fields(text, "SpringColumns"), columns);
}

#[test]
fn a_law_that_reads_nothing() {
    let text = "#[law(adds(force: Force))] struct Wind;";
    holds(
        &law(text),
        &[
            "#[doc(hidden)] pub marker: ::core::marker::PhantomData<R>",
            "WindRow { marker: ::core::marker::PhantomData }",
            "(_source: &VesperSource) -> Self::Row",
        ],
    );
}

#[test]
fn properties_of_every_kind_and_role() {
    let expansion = crate::property::properties(tokens(
        "/// Place.
         pub Position: Vector, \"m\", coordinate;
         /// Speed.
         pub Velocity: Vector, \"m/s\", momentum of Position;
         /// Force.
         pub(crate) Force: Vector, \"N\", sum from ExternalForce;
         /// Share.
         Acceleration: Vector, \"m/s^2\", sum,;
         /// Ends.
         pub Ends: Link<2>;
         /// Attitude.
         pub Attitude: Quaternion;
         /// Fall.
         pub GravityAcceleration = \"gravity\": Vector, \"m/s^2\"",
    ));
    assert!(syn::parse2::<syn::File>(expansion.clone()).is_ok(), "{expansion}");
    holds(
        &plain(&expansion),
        &[
            "#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)] pub struct Position;",
            "impl ::vesper::property::Property for Position { type Kind = ::vesper::property::Vector;",
            "::vesper::property::PropertyInfo::new(\"position\", <<Self as ::vesper::property::Property>::Kind
             as ::vesper::property::KindOf>::KIND, \"m\",).coordinate();",
            "\"m/s\",).momentum_of(<Position as ::vesper::property::Property>::NAME);",
            "pub(crate) struct Force;",
            "\"N\",).sum_from(<ExternalForce as ::vesper::property::Property>::NAME);",
            "\"m/s^2\",).sum();",
            "type Kind = ::vesper::property::Link<2>;",
            "new(\"ends\", <<Self as ::vesper::property::Property>::Kind as ::vesper::property::KindOf>::KIND, \"\",);",
            "type Kind = ::vesper::property::Quaternion;",
            "new(\"gravity\",",
        ],
    );
}

#[test]
fn kernels_of_every_shape() {
    let table: [(&str, &[&str]); 5] = [
        (
            "impl<R: Real> PairLaw<R> for Gravity<R> { fn pair(&self) {} }",
            &[
                "#[inline(always)] fn pair(&self) {}",
                "impl ::vesper::law::PairFamily for Gravity<f64> { type Kernel<R: ::vesper::real::Real> = Gravity<R>;
                 const ENERGY: bool = false; const INVERSE_SQUARE: bool = false;
                 fn kernel<R: ::vesper::real::Real>(&self) -> Gravity<R>
                 { <Self as ::vesper::law::Law>::body::<R>(self) } }",
                "impl ::vesper::backend::Compile for Gravity<f64> {",
                "{ ::vesper::backend::pair::<f64, Self>(self) }",
            ],
        ),
        (
            "impl<T: Real> law::RowLaw<T> for Motion { #[inline] fn row(&self) {} fn energy(&self) {} }",
            &[
                "{ #[inline] fn row(&self) {} #[inline(always)] fn energy",
                "impl ::vesper::law::RowFamily for Motion { type Kernel<T: ::vesper::real::Real> = Motion;",
                "const ENERGY: bool = true;",
                "::vesper::backend::row::<f64, Self>(self)",
                "::core::assert!(<Motion as ::vesper::law::Law>::SIGNATURE.parameters.is_empty(),
                 \"law `Motion` has parameters, so it has a type of numbers: write `for Motion<T>`\")",
            ],
        ),
        ("impl<R: Real> LinkLaw<R> for Spring {}", &["LinkFamily<2> for Spring", "backend::link::<f64, Self, 2>(self)"]),
        (
            "impl<R: Real> LinkLaw<R, 3> for a::Face<R> {}",
            &[
                "LinkFamily<3> for a::Face<f64>",
                "link::<f64, Self, 3>(self)",
                "match <a::Face<f64> as ::vesper::law::Law>::SIGNATURE.link {
                 ::core::option::Option::Some(link) => link.kind.width() == 3,",
                "\"law `Face` does not get as many rows as its link holds: write that number in `LinkLaw<R, N>`\"",
            ],
        ),
        (
            "impl<P: Precision> ColumnLaw<P> for Contact<P> { fn columns(&self) {} }",
            &[
                "{ fn columns(&self) {} }",
                "impl ::vesper::law::ColumnFamily for Contact<f64> { type Kernel<P: ::vesper::real::Scalar> = Contact<P>;
                 fn kernel<P: ::vesper::real::Scalar>(&self) -> Contact<P>",
                "::vesper::backend::column::<f64, Self>(self)",
            ],
        ),
    ];
    for (text, fragments) in table {
        let expansion = crate::kernel::kernel(tokens(""), tokens(text));
        assert!(syn::parse2::<syn::File>(expansion.clone()).is_ok(), "{expansion}");
        holds(&plain(&expansion), fragments);
    }
}
