//! What can be told of input files before anything is prepared.

use crate::{EvalError, Plan};

impl Plan<'_> {
    /// What is wrong with the files that the plan reads, as far as their headers tell: what an evaluation would fail with, of
    /// every node at once. Decodes no pixel.
    ///
    /// Files that do not exist may be made yet, and those that the document may not reach are not opened: neither is told here.
    pub fn examine(&self) -> Vec<EvalError> {
        let fault = |(id, wanted): &(_, Vec<Vec<bool>>)| {
            let stage = self.stage(*id)?;
            let is_there = stage.files(&self.context).iter().all(|file| file.exists());
            if !is_there || self.graph.refused(*id, &self.context).is_some() {
                return None;
            }
            let error = stage.examine(&self.context, wanted).err()?;
            Some(EvalError::of(self.graph, *id, error))
        };
        self.prepares.iter().filter_map(fault).collect()
    }
}
