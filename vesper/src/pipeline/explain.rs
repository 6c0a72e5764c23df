//! The graph for people: who runs, in which order, why, in which passes; who does not.

use super::Pipeline;
use super::bind::{BoundPass, Pass};
use super::plan::Key;
use crate::error::counted;
use crate::integrate::{Integrator, Part};
use crate::law::{Place, Shape};
use crate::real::Scalar;
use crate::registry::{Seat, Status, Tie};
use crate::state::State;
use core::fmt::Write;

impl<P: Scalar> Pipeline<P> {
    /// Order, reasons, passes, dormant and pruned laws, unused columns.
    pub(crate) fn explain(&self, state: &State<P>, integrator: &dyn Integrator) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let mut line = |words: String| _ = writeln!(text, "{words}");
        line(format!("integrator {} (order {}), precision {}", integrator.name(), integrator.order(), P::NAME));
        if let Some(remark) = integrator.remark(&self.structure) {
            line(format!("  {remark}"));
        }
        if !self.structure.jumps.is_empty() {
            let does = if self.switches.any() { "end at" } else { "go across" };
            line(format!("  steps {does} jumps of {}", self.structure.jumps.join(", ")));
        }
        let running = |law: usize| matches!(self.registry.report.laws[law].status, Status::Active { .. });
        line("order of an evaluation:".to_owned());
        let order = self.graph.order.iter().filter(|&&index| running(self.registry.seats[index].law));
        for (place, &index) in order.enumerate() {
            let seat = &self.registry.seats[index];
            line(format!("  {:2}. level {} {}", place + 1, self.graph.level[index], self.described(seat, state)));
            for port in self.ports(seat, state) {
                line(format!("        {port}"));
            }
            for edge in self.graph.edges.iter().filter(|edge| edge.to == index) {
                let before = self.entries[self.registry.seats[edge.from].law].label();
                let (does, name) = (edge.from_mode.word(), self.registry.name(edge.quantity, state));
                line(format!("        after {before}, which {does} {name}"));
            }
        }
        for (key, asked) in [
            (Key::Evaluate(Part::Momenta), "rates of momenta"),
            (Key::Evaluate(Part::Coordinates), "rates of coordinates"),
            (Key::KickDrift, "kick and drift in one go"),
            (Key::Amend, "after a step"),
            (Key::Observe, "for observers, once a frame"),
        ] {
            let passes = &self.programs[key.index()].passes;
            if passes.is_empty() {
                continue;
            }
            let count = if passes.len() == 1 { "1 pass".to_owned() } else { format!("{} passes", passes.len()) };
            line(format!("{asked}: {count}"));
            for pass in passes {
                line(format!("  {}", self.pass(pass)));
                if let (true, Pass::Device(_)) = (self.has_lost_device(), &pass.pass) {
                    line("    not on the graphics processor: it is gone".to_owned());
                }
                if let Some(reason) = &pass.refused {
                    line(format!("    not on the graphics processor: {reason}"));
                }
            }
        }
        self.moves(state).into_iter().for_each(&mut line);
        for law in &self.registry.report.laws {
            if !matches!(law.status, Status::Active { .. }) {
                line(law.to_string());
            }
        }
        for unused in &self.registry.report.unused {
            line(format!("{unused} is unused: no running law touches it"));
        }
        text
    }

    /// The most threads that a pass of this law uses; 0 where none runs.
    pub(crate) fn threads(&self, law: usize) -> usize {
        let passes = self.programs.iter().flat_map(|program| &program.passes).filter(|pass| pass.laws.contains(&law));
        let threads = passes.map(|pass| match self.where_it_runs(&pass.pass) {
            Pass::Device(_) => 1,
            Pass::Group(group) => group.threads(),
            Pass::Pair(pair) => pair.threads,
            Pass::Link(link) => link.threads,
            Pass::Column(_) | Pass::Axpy { .. } | Pass::Release(_) | Pass::Hold(_) | Pass::Keep { .. } => 1,
        });
        threads.max().unwrap_or(0)
    }

    /// Whether a pass of this law runs on a graphics processor.
    pub(crate) fn is_on_device(&self, law: usize) -> bool {
        let mut passes = self.programs.iter().flat_map(|program| &program.passes);
        let on_device = |pass: &Pass<P>| matches!(self.where_it_runs(pass), Pass::Device(_));
        passes.any(|pass| pass.laws.contains(&law) && on_device(&pass.pass))
    }

    /// A pass, or that of the host where the device of this one is gone.
    fn where_it_runs<'p>(&self, pass: &'p Pass<P>) -> &'p Pass<P> {
        match pass {
            Pass::Device(on_device) if self.has_lost_device() => on_device.host(),
            own => own,
        }
    }

    fn described(&self, seat: &Seat, state: &State<P>) -> String {
        let entry = &self.entries[seat.law];
        let all = state.domains[seat.domain].rows;
        let rows = seat.rows.as_ref().map_or(all, Vec::len);
        let domain = &state.domains[seat.domain].name;
        let on = if rows == all {
            format!("{} of {domain}", counted(rows, "row"))
        } else {
            format!("{rows} of {} of {domain}", counted(all, "row"))
        };
        let work = match entry.shape {
            Shape::Pair => format!(", {} pairs", rows * rows.saturating_sub(1) / 2),
            Shape::Row | Shape::Link | Shape::Column => String::new(),
        };
        let every =
            if entry.options.every > 1 { format!(", every {} steps", entry.options.every) } else { String::new() };
        format!("{}: {} law on {on}{work}{every}", entry.label(), entry.shape.word())
    }

    fn ports(&self, seat: &Seat, state: &State<P>) -> Vec<String> {
        let signature = &self.entries[seat.law].signature;
        let said = |(port, tie): (&crate::law::Port, &Tie)| {
            let what = match tie {
                Tie::Quantity(id) => self.registry.name(*id, state),
                Tie::Field(field) => format!("field {}", state.fields[*field].0.name),
                Tie::Default(_) => format!("{}, by default", port.property.name),
                Tie::Absent => format!("{}, which is not there", port.property.name),
            };
            let by = if port.place == Place::End { " of the rows linked to" } else { "" };
            let unit = if port.property.unit.is_empty() { String::new() } else { format!(" [{}]", port.property.unit) };
            format!("{} {what}{unit}{by}", port.mode.word())
        };
        signature.ports.iter().zip(&seat.ties).map(said).collect()
    }

    fn pass(&self, pass: &BoundPass<P>) -> String {
        let mut laws: Vec<&str> = pass.laws.iter().map(|&law| self.entries[law].label()).collect();
        laws.dedup();
        let laws = laws.join(", ");
        let threads = |threads: usize| if threads > 1 { format!(", {threads} threads") } else { String::new() };
        match self.where_it_runs(&pass.pass) {
            Pass::Device(_) => format!("on the graphics processor: {laws}"),
            Pass::Group(group) => {
                let loops = if group.fused { "one loop composed at compile time" } else { "block by block" };
                let laws = if laws.is_empty() { "start of sums".to_owned() } else { laws };
                format!("rows: {laws} ({loops}{})", threads(group.threads()))
            }
            Pass::Pair(pair) => {
                format!("pairs: {laws} ({} rows{}{})", pair.rows, pair.way(), threads(pair.threads))
            }
            Pass::Link(link) => format!("links: {laws} ({} links{})", link.links, threads(link.threads)),
            Pass::Column(_) => format!("columns: {laws}"),
            Pass::Axpy { .. } => "states advance by their rates".to_owned(),
            Pass::Release(_) => format!("shares of {laws} begin anew, every {} steps", pass.every),
            Pass::Hold(_) => format!("held shares of {laws} are added"),
            Pass::Keep { switch: true, .. } => "switches are kept, and held while a step is taken".to_owned(),
            Pass::Keep { .. } => "results are kept for laws that look back at them".to_owned(),
        }
    }
}
