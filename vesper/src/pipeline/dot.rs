//! The graph in the language of Graphviz.

use super::Pipeline;
use crate::property::Role;
use crate::real::Scalar;
use crate::registry::{Status, Tie};
use crate::state::State;
use core::fmt::Write;

impl<P: Scalar> Pipeline<P> {
    /// A node for each law, an edge for each property that one law makes and another one reads, with its mode and name.
    pub(crate) fn to_dot(&self, state: &State<P>) -> String {
        let mut dot =
            String::from("digraph laws {\n  rankdir = LR;\n  node [shape = box, fontname = \"sans-serif\"];\n");
        // Writing to a string cannot fail.
        let mut line = |text: String| _ = writeln!(dot, "  {text}");
        for (place, &index) in self.graph.order.iter().enumerate() {
            let seat = &self.registry.seats[index];
            let entry = &self.entries[seat.law];
            let pruned = matches!(self.registry.report.laws[seat.law].status, Status::Pruned { .. });
            let style = if pruned { ", style = dashed" } else { "" };
            line(format!(
                "l{index} [label = \"{}. {}\\n{} law on {}\"{style}];",
                place + 1,
                escape(entry.label()),
                entry.shape.word(),
                escape(&state.domains[seat.domain].name),
            ));
        }
        for edge in &self.graph.edges {
            line(format!(
                "l{} -> l{} [label = \"{} {}\"];",
                edge.from,
                edge.to,
                edge.from_mode.word(),
                escape(&self.registry.name(edge.quantity, state)),
            ));
        }
        for state_id in self.states() {
            let name = escape(&self.registry.name(state_id, state));
            let moved = match self.registry.quantities[state_id].info.role {
                Role::Coordinate => "drifted",
                Role::Momentum(_) => "kicked",
                Role::Plain | Role::Switch | Role::Sum { .. } | Role::Turn { .. } => "integrated",
            };
            line(format!("q{state_id} [label = \"{name}\\n{moved}\", shape = ellipse];"));
            for (index, seat) in self.registry.seats.iter().enumerate() {
                let ports = self.entries[seat.law].signature.ports.iter().zip(&seat.ties);
                for (port, _) in ports.filter(|(port, tie)| **tie == Tie::Quantity(state_id) && !port.mode.is_input()) {
                    line(format!("l{index} -> q{state_id} [label = \"{}\"];", port.mode.word()));
                }
            }
        }
        dot.push_str("}\n");
        dot
    }
}

fn escape(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"")
}
