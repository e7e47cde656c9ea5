//! Where the samples of a batch are.

/// Inputs and outputs of a batch, wherever a renderer keeps them.
///
/// Channels of inputs are counted over all slots, in their order; see [`Slot::first`](super::Slot::first). Before any
/// sample of a block of at most 512 is written, all its inputs are read; so a batch may write where it reads, sample by
/// sample.
pub trait Batch {
    /// Copies the samples of an input channel from sample `start` on.
    fn read(&mut self, channel: usize, start: usize, to: &mut [f32]);

    /// Takes the samples of an output channel from sample `start` on.
    fn write(&mut self, channel: usize, start: usize, from: &[f32]);
}
