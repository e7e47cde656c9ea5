//! Ends of ranges and hostile data: whatever a document says, it is refused with a reason, or its pictures are right.

mod ends;
mod graphs;
