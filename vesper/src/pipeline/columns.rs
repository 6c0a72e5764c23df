//! Which results of laws have a column. In: plans. Out: columns in the state for what outlives a pass, is looked at, or is
//! looked back at; the rest lives in a scratch of a block. Never: a value.

use super::Pipeline;
use super::operand::Operand;
use super::plan::{Key, Placed, Plan};
use crate::column::Column;
use crate::property::Role;
use crate::real::Scalar;
use crate::registry::{Backend, QuantityId};
use crate::state::State;

impl Plan {
    /// Whether a computed quantity lives in one pass only, so that a scratch of a block is enough for it.
    pub(crate) fn is_transient<P: Scalar>(&self, quantity: QuantityId, pipeline: &Pipeline<P>) -> bool {
        let known = &pipeline.registry.quantities[quantity];
        let looked_at = self.key == Key::Observe && pipeline.observed.contains(&quantity)
            || self.key == Key::Turners && pipeline.turners().any(|turned| turned == quantity);
        let computed = !known.given && !pipeline.states().contains(&quantity);
        let passes: Vec<&Vec<Placed>> = self
            .passes
            .iter()
            .filter(|pass| pass.iter().any(|op| op.operands.iter().any(|at| at.quantity() == Some(quantity))))
            .collect();
        // A constant is read as one number, from where it stays.
        let constant =
            |op: &Placed| op.operands.iter().any(|at| matches!(at, Operand::Constant(id, _) if *id == quantity));
        let constant = passes.iter().copied().flatten().any(constant);
        let one_pass = matches!(passes.as_slice(), [pass] if pass.iter().all(|op| op.row_local && op.rows.is_none()));
        let switch = known.info.role == Role::Switch;
        // The scratch of a block is the host's.
        let on_device = passes.iter().copied().flatten().any(|op| op.backend == Backend::Gpu);
        computed && !looked_at && !switch && !constant && one_pass && !on_device
    }
}

/// Gives every computed quantity that outlives a pass a column in the state.
pub(crate) fn materialise<P: Scalar>(plan: &Plan, pipeline: &Pipeline<P>, state: &mut State<P>) {
    for pass in &plan.passes {
        for operand in pass.iter().flat_map(|op| &op.operands) {
            let switch = |id: &QuantityId| pipeline.registry.quantities[*id].info.role == Role::Switch;
            let looked_back_at = match *operand {
                Operand::Previous(id, _) => Some(id),
                // What it was when the step began is asked by integrators, if not by the law.
                _ => operand.quantity().filter(switch),
            };
            if let Some(id) = looked_back_at {
                let known = &pipeline.registry.quantities[id];
                let domain = &mut state.domains[known.domain];
                if !domain.previous.iter().any(|column| column.info.name == known.info.name) {
                    domain.previous.push(Column::computed(known.info, domain.rows, 0));
                    state.changed_layout();
                }
            }
            let Some(id) = operand.quantity() else { continue };
            let known = &pipeline.registry.quantities[id];
            if state.domains[known.domain].find(known.info.name).is_some() || plan.is_transient(id, pipeline) {
                continue;
            }
            let domain = &mut state.domains[known.domain];
            let stream = domain.columns.iter().map(|column| column.info.kind.width()).sum();
            domain.columns.push(Column::computed(known.info, domain.rows, stream));
            state.changed_layout();
        }
    }
}
