//! The standard properties: the words that strangers' law crates agree on. Anyone declares more in a file of their own.

use super::{Property, PropertyInfo};
use vesper_macros::property;

property! {
    /// Place of a row.
    pub Position: Vector, "m", coordinate;
    /// Rate of change of the position.
    pub Velocity: Vector, "m/s", momentum of Position;
    /// Momentum as a state of its own, where it is not mass times velocity.
    pub Momentum: Vector, "kg m/s", momentum of Position;
    /// Inertial mass; a row of mass 0 is immovable.
    pub Mass: Scalar, "kg";
    /// Mass of a row at rest.
    pub RestMass: Scalar, "kg";
    /// Force that the client applies; the sum of forces starts from it.
    pub ExternalForce: Vector, "N";
    /// Sum of all forces.
    pub Force: Vector, "N", sum from ExternalForce;
    /// What turns velocities without changing their magnitude: a force velocity x turn, such as that of a magnetic field.
    pub Turn: Vector, "kg/s", turn of Force by Velocity;
    /// Sum of all accelerations, where laws give these instead of forces.
    pub Acceleration: Vector, "m/s^2", sum;
    /// Constant of gravitation times mass, known more exactly than either.
    pub StandardGravitationalParameter: Scalar, "m^3/s^2";
    /// Electric charge.
    pub Charge: Scalar, "C";
    /// Coefficient of linear drag: force per velocity.
    pub DragCoefficient: Scalar, "kg/s";
    /// Coefficient of quadratic drag: force per square of velocity.
    pub QuadraticDragCoefficient: Scalar, "kg/m";
    /// Velocity of the medium around.
    pub WindVelocity: Vector, "m/s";

    /// The two rows that a spring joins.
    pub Ends: Link<2>;
    /// The three rows that a face spans.
    pub Corners: Link<3>;
    /// Force of a spring per length of its strain.
    pub Stiffness: Scalar, "N/m";
    /// Force of a damper per velocity of its ends along its axis.
    pub Damping: Scalar, "N s/m";
    /// Length at which a spring is at ease.
    pub RestLength: Scalar, "m";

    /// Lengths after which a scene comes again, in each direction; 0 for never. Pair laws with a cut-off see all images of a row.
    pub PeriodicBox: Vector, "m";
    /// Time of the state, kept by the engine in the domain "scene".
    pub Time: Scalar, "s";
    /// Uniform acceleration of free fall.
    pub GravityAcceleration = "gravity": Vector, "m/s^2";
    /// Speed of light in vacuum.
    pub SpeedOfLight: Scalar, "m/s";
    /// Acceleration of free fall as a function of position.
    pub GravityField: Vector, "m/s^2";
    /// Electric field as a function of position.
    pub ElectricField: Vector, "V/m";
    /// Magnetic flux density as a function of position.
    pub MagneticField: Vector, "T";
}

/// All of them; a test holds the list against the declarations.
pub const STANDARD_PROPERTIES: &[PropertyInfo] = &[
    Position::INFO,
    Velocity::INFO,
    Momentum::INFO,
    Mass::INFO,
    RestMass::INFO,
    ExternalForce::INFO,
    Force::INFO,
    Turn::INFO,
    Acceleration::INFO,
    StandardGravitationalParameter::INFO,
    Charge::INFO,
    DragCoefficient::INFO,
    QuadraticDragCoefficient::INFO,
    WindVelocity::INFO,
    Ends::INFO,
    Corners::INFO,
    Stiffness::INFO,
    Damping::INFO,
    RestLength::INFO,
    PeriodicBox::INFO,
    Time::INFO,
    GravityAcceleration::INFO,
    SpeedOfLight::INFO,
    GravityField::INFO,
    ElectricField::INFO,
    MagneticField::INFO,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_has_every_standard_property() {
        let source = include_str!("standard.rs").split("/// All of them;").next().unwrap();
        let names = source.lines().filter_map(|line| line.trim().strip_prefix("pub "));
        let declared: Vec<&str> = names.map(|rest| rest.split([':', ' ']).next().unwrap_or_default()).collect();
        let list = include_str!("standard.rs").lines();
        let listed: Vec<&str> = list.filter_map(|line| line.trim().strip_suffix("::INFO,")).collect();
        assert_eq!(listed, declared);
        assert_eq!(STANDARD_PROPERTIES.len(), declared.len());
    }
}
