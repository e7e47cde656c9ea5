//! The order in which engines walk over nodes.

use crate::{CheckedNode, NodeId, OutputSpec};

/// Step of the walk.
enum Step {
    /// Visit a node, unless it was visited before.
    Enter(NodeId),
    /// All inputs of the node are in the order.
    Leave(NodeId),
}

/// Sorts nodes, inputs before the nodes that use them: upstream from the outputs, sorted by name, along ports and
/// lists as they are declared. So the order follows from what is connected to what, never from names of nodes or from
/// their places in the document. Nodes that no output needs, which no engine evaluates, come last.
///
/// The connections have no loops.
pub(super) fn order_of_use(nodes: &[CheckedNode], outputs: &[OutputSpec]) -> Vec<NodeId> {
    let mut outputs: Vec<&OutputSpec> = outputs.iter().collect();
    outputs.sort_by(|a, b| a.name.cmp(&b.name));
    let unused = (0..nodes.len()).map(NodeId);
    let mut order = Vec::with_capacity(nodes.len());
    let mut seen = vec![false; nodes.len()];
    for root in outputs.into_iter().map(|output| output.node).chain(unused) {
        let mut open = vec![Step::Enter(root)];
        while let Some(step) = open.pop() {
            match step {
                Step::Leave(id) => order.push(id),
                Step::Enter(id) if std::mem::replace(&mut seen[id.0], true) => {}
                Step::Enter(id) => {
                    open.push(Step::Leave(id));
                    let first = open.len();
                    nodes[id.0].record.each_node(|input| open.push(Step::Enter(input)));
                    // The last one on the stack is the next.
                    open[first..].reverse();
                }
            }
        }
    }
    order
}
