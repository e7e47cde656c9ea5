//! Groups of nodes: what their uses look like, their insides, and the edits that make, unpack and change them.

mod body;
mod document_knobs;
mod face;
mod follower;
mod knobs;
mod library;
mod link;
mod local;
mod make;
mod unpack;
mod within;
mod written;

pub use document_knobs::{
    added_knob, deleted_knob, described, document_knob, document_value, promoted_to_document, renamed_document_knob,
};
pub use face::{document_knobs, kept_items, whole_default};
pub use follower::follower;
pub use knobs::{
    declared_at, groups_using, promoted, relinked_to, renamed_group, renamed_input, renamed_knob, renamed_output,
};
pub use library::{Group, Library};
pub use local::{copied, made_local};
pub use make::grouped;
pub use unpack::unpacked;
pub use within::{OUTPUT, Within, definition_path, enter, is_node, known_kind, needed};
pub use written::{NotWritten, Written, rewritten};

/// Why a command on groups cannot be carried out, as a sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoGroup {
    /// Nothing that can be in a group is selected.
    #[error("Nothing is selected that can be grouped: select some nodes first")]
    Nothing,
    /// A node between those that are selected is not.
    #[error("{0} lies between the selected nodes: select it, too, or fewer of the others")]
    Between(String),
    /// The node is not a use of a group.
    #[error("{0} is not a use of a group: select one to unpack it")]
    NoUse(String),
    /// The use is disabled.
    #[error("{0} is disabled and only passes on its first input: enable it (D), then unpack it")]
    Disabled(String),
    /// A literal would stand where only a node can.
    #[error("an output takes {0}, which would be a value after unpacking: connect a node there first")]
    Literal(String),
    /// A knob stands in a formula, which takes no values of its type.
    #[error("the value of {0} cannot be written into the formula that uses it: set it to a number first")]
    Formula(String),
    /// An input has an output that its connection cannot have.
    #[error("the nodes inside take the output \"{output}\" of the input \"{input}\": connect a node with it first")]
    Output {
        /// The input.
        input: String,
        /// The output.
        output: String,
    },
    /// The place is no knob.
    #[error("only a knob of a node within a group can be promoted: enter a group, and select a node")]
    NoKnob,
    /// The value is a link already.
    #[error("{0} is a link already: change what it leads to instead")]
    Linked(String),
    /// Values follow a knob of the document.
    #[error("the knob {0} cannot be deleted, because {1} follows it: remove the links first")]
    Followed(String, String),
    /// The definition is in another file.
    #[error(
        "the group {group} belongs to {file}, which this document only includes: choose Make local to copy it here"
    )]
    Included {
        /// The group.
        group: String,
        /// The file.
        file: String,
    },
    /// The definition is in this document.
    #[error("the group {0} is part of this document already")]
    Local(String),
    /// A path cannot be written.
    #[error(transparent)]
    Path(#[from] super::relocate::NoText),
}
