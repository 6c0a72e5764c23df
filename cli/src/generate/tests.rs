use super::*;

fn made(name: &str, options: &[(&str, &[f64])]) -> Generated {
    let options: Vec<_> = options.iter().map(|(name, value)| ((*name).to_owned(), value.to_vec())).collect();
    build(kind(name).unwrap(), "bodies", &options).unwrap()
}

fn rows(generated: &Generated, property: &str) -> Vec<[f64; 3]> {
    let column = generated.column("bodies", property).unwrap();
    column.values.chunks(3).map(|row| [row[0], row[1], row[2]]).collect()
}

fn values<'a>(generated: &'a Generated, domain: &str, property: &str) -> &'a [f64] {
    &generated.column(domain, property).unwrap().values
}

fn momentum(generated: &Generated) -> f64 {
    let (mass, velocity) = (values(generated, "bodies", "mass"), rows(generated, "velocity"));
    let (mut sum, mut size) = ([0.0; 3], 0.0);
    for (m, v) in mass.iter().zip(&velocity) {
        (0..3).for_each(|axis| sum[axis] += m * v[axis]);
        size += m * distance(*v, [0.0; 3]);
    }
    distance(sum, [0.0; 3]) / size
}

#[test]
fn every_kind_builds_by_default_and_repeats_its_bits() {
    for kind in KINDS {
        let generated = made(kind.name, &[]);
        assert!(generated == made(kind.name, &[]), "{}", kind.name);
        let mut domains: Vec<&str> = generated.domains.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(domains.remove(0), "bodies");
        assert_eq!(domains, kind.also_fills);
        for (domain, columns) in &generated.domains {
            let count = columns[0].values.len() / columns[0].width;
            for column in columns {
                assert_eq!(column.values.len(), count * column.width, "{domain}.{}", column.name);
                assert!(column.values.iter().all(|value| value.is_finite()), "{domain}.{}", column.name);
            }
        }
        for info in kind.options {
            assert!(vesper_dimension::Unit::parse(info.unit).is_ok(), "{}.{}", kind.name, info.name);
            if !info.default.is_empty() {
                assert_eq!(check(kind, info.name, info.default), None);
            }
            // An unshaken lattice has no draws.
            if info.name == "seed" && kind.name != "lattice" {
                assert!(generated != made(kind.name, &[("seed", &[2.0])]), "{}", kind.name);
            }
        }
    }
}

#[test]
fn plummer_sphere_is_in_equilibrium() {
    let n = 2000;
    let sphere = made("plummer", &[("count", &[n as f64]), ("g", &[1.0]), ("seed", &[3.0])]);
    let (position, velocity) = (rows(&sphere, "position"), rows(&sphere, "velocity"));
    let mass = 1.0 / n as f64;
    assert_eq!(values(&sphere, "bodies", "mass"), vec![mass; n]);
    let kinetic: f64 = velocity.iter().map(|v| 0.5 * mass * v.iter().map(|x| x * x).sum::<f64>()).sum();
    let mut potential = 0.0;
    for i in 0..n {
        potential -= (0..i).map(|j| mass * mass / distance(position[i], position[j])).sum::<f64>();
    }
    // Exactly: -2 T / U = 1, U = -3 pi / 32; drawn from 2000 bodies, to a few hundredths.
    assert!((-2.0 * kinetic / potential - 1.0).abs() < 0.05, "{kinetic} {potential}");
    assert!((potential / (-3.0 * std::f64::consts::PI / 32.0) - 1.0).abs() < 0.05, "{potential}");
    assert!(momentum(&sphere) < 1e-14);
    // The half-mass radius is 1.305 a.
    let mut radii: Vec<f64> = position.iter().map(|&x| distance(x, [0.0; 3])).collect();
    radii.sort_by(f64::total_cmp);
    assert!((radii[n / 2] / 1.305 - 1.0).abs() < 0.06, "{}", radii[n / 2]);
}

#[test]
fn galaxy_has_circular_speeds_and_no_momentum() {
    let galaxy = made("galaxy", &[("g", &[2.0]), ("core_mass", &[500.0]), ("sun_mass", &[0.01]), ("seed", &[7.0])]);
    let (position, velocity) = (rows(&galaxy, "position"), rows(&galaxy, "velocity"));
    assert_eq!(position.len(), 1536);
    let from_core = |i: usize| distance(position[i], position[0]);
    for i in 1..1536 {
        let inside = 500.0 + 0.01 * (1..1536).filter(|&j| from_core(j) < from_core(i)).count() as f64;
        let speed = distance(velocity[i], velocity[0]);
        assert!((speed * speed * from_core(i) / (2.0 * inside) - 1.0).abs() < 1e-10);
        let along: f64 = (0..3).map(|x| (position[i][x] - position[0][x]) * (velocity[i][x] - velocity[0][x])).sum();
        assert!(along.abs() < 1e-10 * speed * from_core(i));
    }
    assert!(momentum(&galaxy) < 1e-13);
}

#[test]
fn lattice_counts_and_spacing() {
    let lattice = made("lattice", &[("count", &[27.0]), ("spacing", &[2.0]), ("speed", &[1.0])]);
    let position = rows(&lattice, "position");
    assert_eq!((position[0], position[13], position[26]), ([-2.0; 3], [0.0; 3], [2.0; 3]));
    assert!(momentum(&lattice) < 1e-15);
    let shaken = made("lattice", &[("count", &[28.0]), ("jitter", &[0.1])]);
    assert_eq!(rows(&shaken, "position").len(), 28);
    let on_lattice = |x: f64| ((x + 1.5) - (x + 1.5).round()).abs();
    let largest = rows(&shaken, "position").iter().flatten().map(|&x| on_lattice(x)).fold(0.0, f64::max);
    assert!(largest > 0.05 && largest <= 0.1, "{largest}");
}

#[test]
fn web_is_fixed_at_the_rim_and_displaced_inside() {
    let web = made("web", &[]);
    let mass = values(&web, "bodies", "mass");
    assert_eq!(mass.len(), 20);
    assert_eq!((&mass[..15], &mass[15..]), (&[1.0; 15][..], &[0.0; 5][..]));
    let still = made("web", &[("displacement", &[0.0]), ("tension", &[0.25])]);
    assert_eq!(rows(&web, "position")[15..], rows(&still, "position")[15..]);
    assert!(rows(&web, "position").iter().zip(rows(&still, "position")).take(15).all(|(a, b)| *a != b));
    let ends = values(&still, "springs", "ends");
    assert_eq!(ends.len(), 2 * 30);
    let position = rows(&still, "position");
    for (ends, rest) in ends.chunks(2).zip(values(&still, "springs", "rest_length")) {
        let length = distance(position[ends[0] as usize], position[ends[1] as usize]);
        assert!((rest / length - 0.75).abs() < 1e-12);
    }
    let faults = build(kind("web").unwrap(), "bodies", &[("count".to_owned(), vec![21.0])]).unwrap_err();
    assert_eq!(faults[0].option.as_deref(), Some("count"));
}

#[test]
fn icosahedron_is_regular() {
    let options: &[(&str, &[f64])] =
        &[("centre_mass", &[50.0]), ("turn", &[0.3, 0.2, 0.1]), ("floor", &[1000.0]), ("slope", &[0.2])];
    let shell = made("icosahedron", options);
    let position = rows(&shell, "position");
    assert_eq!(position.len(), 16);
    assert_eq!(values(&shell, "bodies", "mass")[11..], [100.0, 50.0, 0.0, 0.0, 0.0]);
    let ends = values(&shell, "springs", "ends");
    let rest = values(&shell, "springs", "rest_length");
    assert_eq!(ends.len(), 2 * 42);
    for (ends, rest) in ends.chunks(2).zip(rest) {
        assert!((distance(position[ends[0] as usize], position[ends[1] as usize]) - rest).abs() < 1e-12);
    }
    assert!(rest[..30].iter().all(|&rest| (rest - 5.257_311_121_191_336).abs() < 1e-14));
    assert_eq!(rest[30..], [5.0; 12]);
    let faces = values(&shell, "faces", "vertices");
    assert_eq!(faces.len(), 3 * 21);
    let mut uses = [0; 16];
    for (index, face) in faces.chunks(3).enumerate() {
        let [a, b, c] = [0, 1, 2].map(|corner| position[face[corner] as usize]);
        let [u, v] = [b, c].map(|end| [0, 1, 2].map(|x| end[x] - a[x]));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let outward =
            if index == 20 { [0.2_f64.sin(), 0.0, 0.2_f64.cos()] } else { [0, 1, 2].map(|x| a[x] - position[12][x]) };
        assert!((0..3).map(|x| normal[x] * outward[x]).sum::<f64>() > 0.0, "face {index}");
        face.iter().for_each(|&corner| uses[corner as usize] += 1);
    }
    assert_eq!(uses[..12], [5; 12]);
    let down = rows(&made("icosahedron", &[("face_down", &[1.0])]), "position");
    assert!(down[..3].iter().all(|place| (place[2] - (100.0 - 3.973_272_361_458_825)).abs() < 1e-10));
    assert!(down[3..12].iter().all(|place| place[2] > 99.0));
}

#[test]
fn options_are_checked() {
    let given: Vec<(String, Vec<f64>)> = [("cuont", 5.0), ("count", 2.5), ("g", -1.0), ("radius", 1.0)]
        .map(|(name, value)| (name.to_owned(), vec![value]))
        .to_vec();
    let faults = build(kind("plummer").unwrap(), "bodies", &given).unwrap_err();
    let texts: Vec<&str> = faults.iter().map(|fault| fault.text.as_str()).collect();
    assert_eq!(
        texts,
        [
            "generator `plummer` has no option `cuont`",
            "expected a whole number from 1 to 100000000 for `count`, found 2.5",
            "expected more than 0 for `g`, found -1",
        ]
    );
    assert_eq!(faults[0].help.as_deref(), Some("did you mean `count`?"));
}
