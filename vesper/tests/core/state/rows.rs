//! Rows that come and go; links follow.

use super::*;

fn bodies(places: &[f64]) -> Domain<f64> {
    let places: Vec<[f64; 3]> = places.iter().map(|&x| [x, 0.0, 0.0]).collect();
    let count = places.len();
    Domain::new("bodies").with(Position, places).with(Velocity, vec![[0.0; 3]; count]).with(Mass, vec![1.0; count])
}

fn links(ends: &[[u32; 2]]) -> Domain<f64> {
    let count = ends.len();
    let springs = Domain::new("springs").link(Ends, "bodies", ends.iter().copied());
    springs.with(Stiffness, (0..count).map(|k| k as f64).collect::<Vec<_>>()).with(RestLength, vec![1.0; count])
}

/// Labels that hang on springs, and on bodies too.
fn labels(on: &[(u32, [u32; 2])]) -> Domain<f64> {
    let labels = Domain::new("labels").link(Parent, "springs", on.iter().map(|(spring, _)| [*spring]));
    labels.link(Ends, "bodies", on.iter().map(|(_, ends)| *ends))
}

fn ends(state: &State<f64>) -> Vec<f64> {
    state.numbers("springs", Ends).unwrap()
}

#[test]
fn links_follow_rows_that_move_up() {
    let mut state = State::new([bodies(&[0.0, 1.0, 2.0, 3.0]), links(&[[1, 2], [2, 3], [3, 1]])], []).unwrap();
    state.remove_rows("bodies", &[0]).unwrap();
    assert_eq!(ends(&state), [0.0, 1.0, 1.0, 2.0, 2.0, 0.0]);
    assert_eq!(state.get("bodies", Position, 0).unwrap().x, 1.0);
}

#[test]
fn a_link_goes_with_the_row_that_it_leads_to_and_so_on() {
    let springs = links(&[[0, 1], [1, 2], [2, 3]]);
    let labels = labels(&[(0, [2, 3]), (1, [3, 3]), (2, [2, 3]), (2, [0, 3]), (1, [2, 3])]);
    let mut state = State::new([labels, bodies(&[0.0, 1.0, 2.0, 3.0]), springs], []).unwrap();
    state.remove_rows("bodies", &[1, 1]).unwrap();
    assert_eq!(state.domain("bodies").unwrap().rows(), 3);
    // Springs 0 and 1 led to body 1; with them went the labels on them. The rest is counted anew.
    assert_eq!(ends(&state), [1.0, 2.0]);
    assert_eq!(state.values("springs", Stiffness).unwrap(), [2.0]);
    assert_eq!(state.numbers("labels", Parent).unwrap(), [0.0, 0.0]);
    assert_eq!(state.numbers("labels", Ends).unwrap(), [1.0, 2.0, 0.0, 2.0]);
}

#[test]
fn rows_may_link_to_rows_of_their_own_domain() {
    let tree =
        |parents: &[u32]| Domain::<f64>::new("tree").link(Parent, "tree", parents.iter().map(|&parent| [parent]));
    let mut state = State::new([tree(&[0, 0, 1, 2])], []).unwrap();
    state.add_rows(tree(&[3, 5])).unwrap();
    assert_eq!(state.numbers("tree", Parent).unwrap(), [0.0, 0.0, 1.0, 2.0, 3.0, 5.0]);
    assert!(state.add_rows(tree(&[7])).is_err(), "there are seven rows with it: 0 to 6");
    state.remove_rows("tree", &[2]).unwrap();
    assert_eq!(state.numbers("tree", Parent).unwrap(), [0.0, 0.0, 2.0], "row 3 hung on row 2, row 4 on row 3");
}

#[test]
fn a_run_goes_on_as_if_the_rows_had_always_been_so() {
    for integrator in 0..2 {
        let builder = || {
            let builder =
                Engine::<f64>::builder().law(Gravity::default()).law(Spring).law(Motion).law(Coulomb).step(0.01);
            if integrator == 0 { builder } else { builder.integrator(SemiImplicitEuler) }
        };
        let charged = |domain: Domain<f64>, rows: &[u32]| domain.subset(Charge, rows.to_vec(), vec![1.0; rows.len()]);
        let start = || builder().domain(charged(bodies(&[0.0, 1.0, 2.0]), &[1])).domain(links(&[[0, 1], [1, 2]]));
        let mut engine = start().build().unwrap();
        engine.state_mut().add_rows(charged(bodies(&[4.0, 5.0]), &[1])).unwrap();
        engine.state_mut().add_rows(links(&[[2, 4]])).unwrap();
        engine.state_mut().remove_rows("bodies", &[0]).unwrap();
        engine.advance(0.1).unwrap();
        let springs = links(&[[0, 1], [1, 3]]).rows(2);
        let direct = builder().domain(charged(bodies(&[1.0, 2.0, 4.0, 5.0]), &[0, 3])).domain(springs);
        let mut direct = direct.build().unwrap();
        direct.state_mut().set("springs", Stiffness, 0, 1.0).unwrap();
        direct.state_mut().set("springs", Stiffness, 1, 0.0).unwrap();
        direct.advance(0.1).unwrap();
        assert_eq!(engine.state().hash(), direct.state().hash());
        assert_eq!(engine.state().column("bodies", "charge").unwrap().subset(), Some(&[0, 3][..]));
    }
}

#[test]
fn rows_come_and_go_while_the_engine_runs() {
    let mut engine = Engine::builder().domain(bodies(&[0.0])).law(Motion).law(Gravity::default()).step(0.1);
    engine = engine.observe("bodies", Force);
    let mut engine = engine.build().unwrap();
    for round in 0..100 {
        engine.state_mut().add_rows(bodies(&[f64::from(round), f64::from(round) + 0.5])).unwrap();
        engine.advance(0.1).unwrap();
        let count = engine.state().domain("bodies").unwrap().rows();
        engine.state_mut().remove_rows("bodies", &[count / 2]).unwrap();
        engine.advance(0.1).unwrap();
        assert_eq!(engine.state().values("bodies", Force).unwrap().len(), count - 1);
    }
    let all: Vec<usize> = (0..engine.state().domain("bodies").unwrap().rows()).collect();
    engine.state_mut().remove_rows("bodies", &all).unwrap();
    engine.advance(0.1).unwrap();
    engine.state_mut().add_rows(bodies(&[1.0])).unwrap();
    engine.advance(0.1).unwrap();
    assert_eq!(place(&engine, 0), DVec3::X);
}
